// SPDX-License-Identifier: BSD-3-Clause
#include "view/mesh_reading.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace xview::test {
namespace {

template <class T>
T next(std::istream& in) {
  T value{};
  if (!(in >> value)) throw std::runtime_error("unexpected end");
  return value;
}

void expectWord(std::istream& in, const std::string& expected) {
  const auto word = next<std::string>(in);
  if (word != expected) throw std::runtime_error("expected " + expected + ", found " + word);
}

std::array<std::uint32_t, 3> nextTriangle(std::istream& in) {
  if (next<int>(in) != 3) throw std::runtime_error("not a triangle");
  return {next<std::uint32_t>(in), next<std::uint32_t>(in), next<std::uint32_t>(in)};
}

}  // namespace

ColorMesh readVtk(const std::string& text) {
  std::istringstream in(text);
  std::string line;
  std::getline(in, line);
  if (line.rfind("# vtk DataFile Version", 0) != 0) throw std::runtime_error("no magic");
  std::getline(in, line);  // free text
  for (const char* word : {"ASCII", "DATASET", "POLYDATA", "POINTS"}) expectWord(in, word);
  ColorMesh mesh;
  mesh.vertices.resize(next<std::size_t>(in));
  expectWord(in, "double");
  for (auto& p : mesh.vertices) p = {next<double>(in), next<double>(in), next<double>(in)};
  expectWord(in, "POLYGONS");
  mesh.triangles.resize(next<std::size_t>(in));
  if (next<std::size_t>(in) != 4 * mesh.triangles.size())
    throw std::runtime_error("wrong size of the polygon list");
  for (auto& t : mesh.triangles) t = nextTriangle(in);
  expectWord(in, "POINT_DATA");
  mesh.colors.resize(next<std::size_t>(in));
  expectWord(in, "COLOR_SCALARS");
  expectWord(in, "RGB");
  if (next<int>(in) != 3) throw std::runtime_error("not three colour components");
  for (auto& c : mesh.colors) {
    for (auto& component : c)
      component = static_cast<std::uint8_t>(std::lround(255 * next<double>(in)));
  }
  if (in >> line) throw std::runtime_error("more than expected: " + line);
  return mesh;
}

ColorMesh readPly(const std::string& text) {
  std::istringstream in(text);
  ColorMesh mesh;
  std::string line;
  while (std::getline(in, line) && line != "end_header") {
    std::istringstream words(line);
    std::string element, name;
    std::size_t count = 0;
    if (!(words >> element >> name >> count) || element != "element") continue;
    if (name == "vertex") mesh.vertices.resize(count);
    if (name == "face") mesh.triangles.resize(count);
  }
  mesh.colors.resize(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    mesh.vertices[i] = {next<double>(in), next<double>(in), next<double>(in)};
    for (auto& component : mesh.colors[i]) component = static_cast<std::uint8_t>(next<int>(in));
  }
  for (auto& t : mesh.triangles) t = nextTriangle(in);
  if (in >> line) throw std::runtime_error("more than expected: " + line);
  return mesh;
}

}  // namespace xview::test
