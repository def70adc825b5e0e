// SPDX-License-Identifier: BSD-3-Clause
// xview on several machines (MPI): the first rank is xview, the others scan parts of large maps
// for it.
#include <mpi.h>

#include <algorithm>
#include <cstdint>
#include <exception>
#include <string>

#include "narrative.h"
#include "tool.h"
#include "xview/search/scan_helpers.h"
#include "xview/types/atomic_file.h"
#include "xview/types/library_chatter.h"

namespace xview::tools {
namespace {

constexpr int kFirst = 0;                                 ///< the rank that is xview
constexpr std::uint64_t kPiece = std::uint64_t{1} << 30;  ///< of a message, whose count is an int

/// A message and its size. Whatever goes wrong in MPI ends all ranks (MPI_ERRORS_ARE_FATAL).
void sendTo(int rank, const std::string& message) {
  const std::uint64_t bytes = message.size();
  MPI_Send(&bytes, 1, MPI_UINT64_T, rank, 0, MPI_COMM_WORLD);
  for (std::uint64_t at = 0; at < bytes; at += kPiece)
    MPI_Send(message.data() + at, static_cast<int>(std::min(kPiece, bytes - at)), MPI_BYTE, rank, 0,
             MPI_COMM_WORLD);
}

std::string receiveFrom(int rank) {
  std::uint64_t bytes = 0;
  MPI_Recv(&bytes, 1, MPI_UINT64_T, rank, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  std::string message(bytes, 0);
  for (std::uint64_t at = 0; at < bytes; at += kPiece)
    MPI_Recv(message.data() + at, static_cast<int>(std::min(kPiece, bytes - at)), MPI_BYTE, rank, 0,
             MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return message;
}

/// All ranks but the first, which are told to end with an empty request.
class OtherRanks final : public search::ScanHelpers {
 public:
  OtherRanks() {
    MPI_Comm_size(MPI_COMM_WORLD, &ranks_);
    search::shareScans(this);
  }
  ~OtherRanks() override {
    search::shareScans(nullptr);
    for (int rank = 1; rank < ranks_; ++rank) sendTo(rank, "");
  }
  OtherRanks(const OtherRanks&) = delete;
  OtherRanks& operator=(const OtherRanks&) = delete;

  int count() const override { return ranks_ - 1; }
  void send(int helper, const std::string& request) override { sendTo(helper + 1, request); }
  std::string receive(int helper) override { return receiveFrom(helper + 1); }

 private:
  int ranks_ = 1;
};

void help() {
  search::ScanHelper helper;
  for (std::string request = receiveFrom(kFirst); !request.empty(); request = receiveFrom(kFirst))
    sendTo(kFirst, helper.answer(request));
}

int runRank(int argc, char** argv) {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == kFirst) {
    const OtherRanks others;
    return runProgram({argv + 1, argv + argc});
  }
  try {
    help();
    return kDone;
  } catch (const std::exception& e) {
    Narrative().error("rank " + std::to_string(rank) + ": " + e.what());
    MPI_Abort(MPI_COMM_WORLD, kFailed);
    return kFailed;
  }
}

}  // namespace
}  // namespace xview::tools

int main(int argc, char** argv) {
  xview::removeUnfinishedOnInterrupt();  // before MPI has threads
  xview::allowQuietLibraries();
  int level = MPI_THREAD_SINGLE;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &level);
  if (level < MPI_THREAD_SERIALIZED) {
    xview::tools::Narrative().error("this MPI is not for programs with threads");
    MPI_Abort(MPI_COMM_WORLD, xview::tools::kFailed);
  }
  const int code = xview::tools::runRank(argc, argv);
  MPI_Finalize();
  return code;
}
