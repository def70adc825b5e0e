// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sim/recordings.h"
#include "xview/base/frame.h"
#include "xview/localizer.h"
#include "xview/mapper.h"

namespace xview::test {

/// A short drive through a seeded town, made once for all tests of the process: its map, and what
/// other sessions saw.
struct SimulatedDrive {
  std::map<std::string, std::unique_ptr<SimulatedRecording>>
      sessions;  ///< forward, rear, elsewhere
  std::map<std::string, std::vector<PreprocessedFrame>> frames;
  map::SemanticMap map;  ///< of forward
  LabelSet labels;

  Query query(const std::string& session, std::size_t first, std::size_t last,
              const Options& options = {}) const;
};

const SimulatedDrive& simulatedDrive();

inline std::vector<PreprocessedFrame> movedFrames(const FrameSource& source,
                                                  const Eigen::Isometry3d& T_new_old) {
  return preprocessRecording(PosedRecording(source, T_new_old), {});
}

}  // namespace xview::test
