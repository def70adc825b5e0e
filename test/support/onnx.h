// SPDX-License-Identifier: BSD-3-Clause
// Networks of one layer, written as ONNX by hand.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace xview::test {
namespace protobuf {

inline std::string varint(std::uint64_t value) {
  std::string bytes;
  for (; value >= 0x80; value >>= 7) bytes += static_cast<char>(value | 0x80);
  return bytes + static_cast<char>(value);
}
inline std::string number(int field, std::uint64_t value) {
  return varint(static_cast<std::uint64_t>(field) << 3) + varint(value);
}
inline std::string text(int field, const std::string& bytes) {
  return varint(static_cast<std::uint64_t>(field) << 3 | 2) + varint(bytes.size()) + bytes;
}

inline std::string tensor(const std::string& name, const std::vector<std::uint64_t>& dims,
                          const std::vector<float>& values) {
  std::string bytes;
  for (const std::uint64_t d : dims) bytes += number(1, d);
  const std::string raw(reinterpret_cast<const char*>(values.data()),
                        values.size() * sizeof(float));
  return bytes + number(2, 1) + text(8, name) + text(9, raw);
}

inline std::string port(const std::string& name, const std::vector<std::uint64_t>& dims) {
  std::string shape;
  for (const std::uint64_t d : dims) shape += text(1, number(1, d));
  return text(1, name) + text(2, text(1, number(1, 1) + text(2, shape)));
}

}  // namespace protobuf

/// A network of one layer: y = op(x, weights), with 1 x 3 x rows x columns in.
inline std::string onnxModel(const std::string& op, const std::string& weights, bool has_weights,
                             std::uint64_t rows = 4, std::uint64_t columns = 6) {
  using namespace protobuf;
  std::string node = text(1, "x");
  if (has_weights) node += text(1, "w");
  node += text(2, "y") + text(3, "only") + text(4, op);
  if (has_weights)  // an attribute of integers
    node += text(
        5, text(1, "kernel_shape") + number(8, 1) + number(8, 1) + varint(20 << 3) + varint(7));
  std::string graph = text(1, node) + text(2, "graph");
  if (has_weights) graph += text(5, weights);
  graph += text(11, port("x", {1, 3, rows, columns})) + text(12, port("y", {1, 3, rows, columns}));
  return number(1, 7) + text(8, text(1, "") + number(2, 11)) + text(7, graph);
}

/// A convolution of one pixel: a score for each row of the matrix.
inline std::string onnxScores(const std::vector<std::vector<float>>& matrix, std::uint64_t rows = 4,
                              std::uint64_t columns = 6) {
  std::vector<float> values;
  for (const auto& row : matrix) values.insert(values.end(), row.begin(), row.end());
  return onnxModel("Conv", protobuf::tensor("w", {matrix.size(), 3, 1, 1}, values), true, rows,
                   columns);
}

}  // namespace xview::test
