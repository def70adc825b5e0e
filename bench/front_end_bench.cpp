// SPDX-License-Identifier: BSD-3-Clause
// What one frame costs from the file to the place graph, stage by stage, on one thread.
//
//   front_end_bench RECORDING [SCANS] [--benchmark_filter=...]
//
// RECORDING is a depth+label sequence, SCANS a folder of LiDAR scans. Suitable ones:
//
//   xview simulate DIR --seed 3 --width 640 --height 480 --route_length_m 120 --sessions.lidar
//   front_end_bench DIR/forward DIR/lidar
#include <benchmark/benchmark.h>

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "base/random.h"
#include "place/bev_grid.h"
#include "place/blobs.h"
#include "place/clean_labels.h"
#include "place/lift.h"
#include "place/merge.h"
#include "xview/io/recording.h"
#include "xview/mapper.h"

namespace {

using namespace xview;

constexpr std::size_t kFrames = 16;  ///< spread over the recording

/// Some frames of a recording with what each stage makes of them.
struct Input {
  std::unique_ptr<FrameSource> source;
  std::vector<std::size_t> chosen;
  std::vector<Frame> raw, cleaned;
  std::vector<LabelledCloud> lifted;
  std::vector<PreprocessedFrame> preprocessed_frames;

  const LabelSet& labels() const { return source->labels(); }
};

Options oneThread() {
  Options options;
  options.threads = 1;
  return options;
}

Input makeInput(const std::string& path) {
  const Options options = oneThread();
  Input input;
  input.source = io::openRecording(path);
  const std::size_t count = std::min(kFrames, input.source->size());
  for (std::size_t i = 0; i < count; ++i) {
    input.chosen.push_back(i * input.source->size() / count);
    input.raw.push_back(input.source->read(input.chosen.back()));
    input.cleaned.push_back(input.raw.back());
    Frame& frame = input.cleaned.back();
    frame.label = cleanLabels(frame.label, input.labels(), options.clean);
    input.lifted.push_back(lift(frame, input.labels(), options.lift));
    input.preprocessed_frames.push_back(preprocessFrame(input.raw.back(), input.labels(), options));
  }
  return input;
}

/// Runs `stage(i)` over the frames in turn.
template <class Stage>
void overFrames(benchmark::State& state, const Input& input, const Stage& stage) {
  std::size_t i = 0;
  for (auto _ : state) {
    stage(i);
    i = (i + 1) % input.chosen.size();
  }
  state.SetLabel(std::to_string(input.chosen.size()) + " frames in turn");
}

/// Blobs of things that stand far apart, far from where the frames are.
std::vector<Blob> farAway(std::size_t count, const LabelSet& labels) {
  std::uint32_t object = 0;
  for (const auto& [id, info] : labels.classes()) {
    if (info.role == Role::object) object = id;
  }
  Random random(1);
  std::vector<Blob> blobs(count);
  for (Blob& blob : blobs) {
    blob.label = object;
    blob.points = 50;
    blob.position = {random.uniform(1e4, 1e5), random.uniform(1e4, 1e5), 0};
  }
  return blobs;
}

void registerStages(const std::string& kind, const Input& input) {
  const auto stage = [&](const std::string& name, auto body) {
    benchmark::RegisterBenchmark((kind + "/" + name).c_str(), [&input,
                                                               body](benchmark::State& state) {
      overFrames(state, input, [&](std::size_t i) { body(input, i); });
    })->Unit(benchmark::kMillisecond);
  };
  stage("read", [](const Input& in, std::size_t i) {
    benchmark::DoNotOptimize(in.source->read(in.chosen[i]));
  });
  if (input.source->sensor() == Sensor::camera) {
    stage("clean", [](const Input& in, std::size_t i) {
      benchmark::DoNotOptimize(cleanLabels(in.raw[i].label, in.labels(), CleanOptions()));
    });
    stage("image_blobs", [](const Input& in, std::size_t i) {
      benchmark::DoNotOptimize(extractImageBlobs(in.cleaned[i], in.labels(), 50));
    });
  }
  stage("lift", [](const Input& in, std::size_t i) {
    benchmark::DoNotOptimize(lift(in.cleaned[i], in.labels(), LiftOptions()));
  });
  stage("thin", [](const Input& in, std::size_t i) {
    std::vector<std::uint32_t> points_per_voxel;
    benchmark::DoNotOptimize(thinByVoxel(in.lifted[i], kBevVoxel_m, &points_per_voxel));
  });
  stage("lift_thin", [](const Input& in, std::size_t i) {
    benchmark::DoNotOptimize(liftThin(in.cleaned[i], in.labels(), LiftOptions(), kBevVoxel_m,
                                      WholeClasses::no_surfaces));
  });
  stage("digest", [](const Input& in, std::size_t i) {
    benchmark::DoNotOptimize(preprocessFrame(in.raw[i], in.labels(), oneThread()));
  });
}

/// A frame into a place graph that has `range(0)` vertices already.
void registerMerge(const std::string& kind, const Input& input) {
  benchmark::RegisterBenchmark(
      (kind + "/merge_into").c_str(),
      [&input](benchmark::State& state) {
        PlaceGraphBuilder places(input.labels(), MergeOptions());
        places.add(farAway(static_cast<std::size_t>(state.range(0)), input.labels()), -1);
        overFrames(state, input, [&](std::size_t i) {
          places.add(input.preprocessed_frames[i].blobs, input.preprocessed_frames[i].number);
          places.addSurfacePoints(input.preprocessed_frames[i].cloud,
                                  input.preprocessed_frames[i].number);
        });
      })
      ->Arg(0)
      ->Arg(1000)
      ->Arg(100000)
      ->Arg(1000000)
      ->Unit(benchmark::kMillisecond);
}

void addToView(BevGridBuilder& view, const PreprocessedFrame& preprocessed) {
  view.add(preprocessed.cloud, preprocessed.weights, preprocessed.resolves_thin,
           Eigen::Isometry3d::Identity(), preprocessed.aerial);
}

void registerBevGrid(const std::string& kind, const Input& input) {
  benchmark::RegisterBenchmark((kind + "/plan_view").c_str(), [&input](benchmark::State& state) {
    BevGridBuilder view(input.labels());
    overFrames(state, input, [&](std::size_t i) { addToView(view, input.preprocessed_frames[i]); });
  })->Unit(benchmark::kMillisecond);
}

/// From the image in memory, or from the file, to the updated place graph and BEV grid.
void registerWhole(const std::string& kind, const Input& input) {
  for (const bool from_file : {false, true}) {
    for (const bool with_view : {false, true}) {
      const std::string name = std::string("/whole_frame") + (from_file ? "_with_read" : "") +
                               (with_view ? "_with_plan_view" : "");
      benchmark::RegisterBenchmark((kind + name).c_str(), [&input, from_file,
                                                           with_view](benchmark::State& state) {
        PlaceGraphBuilder places(input.labels(), MergeOptions());
        BevGridBuilder view(input.labels());
        overFrames(state, input, [&](std::size_t i) {
          const PreprocessedFrame preprocessed =
              from_file ? preprocessFrame(input.source->read(input.chosen[i]), input.labels(),
                                          oneThread())
                        : preprocessFrame(input.raw[i], input.labels(), oneThread());
          places.add(preprocessed.blobs, preprocessed.number);
          places.addSurfacePoints(preprocessed.cloud, preprocessed.number);
          if (with_view) addToView(view, preprocessed);
        });
      })->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace

int main(int argc, char** argv) try {
  benchmark::Initialize(&argc, argv);
  if (argc < 2 || argc > 3) {
    std::fprintf(stderr, "usage: front_end_bench RECORDING [SCANS] [--benchmark_...]\n");
    return 2;
  }
  std::vector<Input> inputs;
  for (int i = 1; i < argc; ++i) inputs.push_back(makeInput(argv[i]));
  for (const Input& input : inputs) {
    const std::string kind = input.source->sensor() == Sensor::camera ? "frame" : "scan";
    registerStages(kind, input);
    registerMerge(kind, input);
    registerBevGrid(kind, input);
    registerWhole(kind, input);
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "error: %s\n", e.what());
  return 1;
}
