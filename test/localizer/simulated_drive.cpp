// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/simulated_drive.h"

namespace xview::test {

Query SimulatedDrive::query(const std::string& session, std::size_t first, std::size_t last,
                            const Options& options) const {
  const std::vector<PreprocessedFrame>& all = frames.at(session);
  return makeQuery(all.data() + first, all.data() + last, labels, options);
}

const SimulatedDrive& simulatedDrive() {
  static const SimulatedDrive drive = [] {
    SimulationOptions simulation;
    simulation.seed = 5;
    simulation.route_length_m = 160;
    simulation.width = 240;
    simulation.height = 180;
    simulation.sessions.aerial = false;
    simulation.sessions.elsewhere = true;
    SimulatedDrive made;
    for (auto& session : makeSessions(simulation)) {
      made.frames[session->name()] = preprocessRecording(*session, {});
      made.labels = session->labels();
      made.sessions[session->name()] = std::move(session);
    }
    made.map = buildMap({made.sessions.at("forward").get()}, {});
    return made;
  }();
  return drive;
}

}  // namespace xview::test
