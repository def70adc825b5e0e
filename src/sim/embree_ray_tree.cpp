// SPDX-License-Identifier: BSD-3-Clause
#include "sim/embree_ray_tree.h"

#include <algorithm>

namespace xview {
namespace {

// Other instruction sets round otherwise: this one, so that a seed gives the same scans on
// processors with a later one.
#ifdef __SANITIZE_THREAD__
constexpr const char* kDevice = "max_isa=avx2,threads=1";  // what orders its threads is not seen
#else
constexpr const char* kDevice = "max_isa=avx2";
#endif

RTCGeometry geometryOf(const TriangleMesh& mesh, RTCDevice device) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.vertices.size()));
  for (const Eigen::Vector3f& v : mesh.vertices) vertices = std::copy_n(v.data(), 3, vertices);
  auto* indices = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(std::uint32_t), mesh.triangles.size()));
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    indices = std::copy(t.corner.begin(), t.corner.end(), indices);
  }
  rtcCommitGeometry(geometry);
  return geometry;
}

}  // namespace
}  // namespace xview

RTCScene xviewMakeRayTree(const xview::TriangleMesh& mesh) {
  RTCDevice device = rtcNewDevice(xview::kDevice);
  if (!device) return nullptr;
  RTCScene tree = rtcNewScene(device);
  rtcSetSceneFlags(tree, RTC_SCENE_FLAG_ROBUST);
  if (!mesh.triangles.empty()) {
    RTCGeometry geometry = xview::geometryOf(mesh, device);
    rtcAttachGeometry(tree, geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(tree);
  rtcReleaseDevice(device);  // the scene keeps it
  return tree;
}

void xviewReleaseRayTree(RTCScene tree) { rtcReleaseScene(tree); }

void xviewCastRays(const int* valid, RTCScene tree, RTCRayHit8& packet) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect8(valid, tree, &context, &packet);
}
