// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <embree3/rtcore.h>

#include "sim/render.h"

// The functions of the module xview_ray_casting, which is all that is asked of Embree.
extern "C" {
/// Triangles, ready to be met by rays; the caller releases it. Null if there is no device for it.
RTCScene xviewMakeRayTree(const xview::TriangleMesh& mesh);
void xviewReleaseRayTree(RTCScene tree);
/// Shortens those of eight rays that are valid and meet a triangle, which `packet` then names.
void xviewCastRays(const int* valid, RTCScene tree, RTCRayHit8& packet);
}
