// SPDX-License-Identifier: BSD-3-Clause
// PLY graphs. What is read is written and read again; then nothing changes.
#include "fuzz.h"
#include "io/graph_files.h"
#include "xview/io/recording.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace xview;
  const std::string path =
      fuzz::written("in.ply", std::string(reinterpret_cast<const char*>(data), size));
  fuzz::isDone([&] { io::recogniseInput(path); });
  io::GraphFile file;
  if (!fuzz::isDone([&] { file = io::readGraph(path); })) return 0;
  fuzz::require(isConsistent(file.graph));
  const std::string copy = fuzz::scratch() + "/out.ply";
  const LabelSet labels = file.labels.value_or(LabelSet());
  if (!fuzz::isDone([&] { io::writeGraph(copy, file.graph, labels); })) return 0;
  const io::GraphFile again = io::readGraph(copy);
  fuzz::require(again.graph.size() == file.graph.size());
  fuzz::require(again.graph.edges() == file.graph.edges());
  fuzz::require(!file.labels || !again.labels || *again.labels == *file.labels);
  for (std::size_t i = 0; i < file.graph.size(); ++i) {
    fuzz::require(again.graph.vertices[i].position == file.graph.vertices[i].position);
    fuzz::require(again.graph.vertices[i].label == file.graph.vertices[i].label);
  }
  return 0;
}
