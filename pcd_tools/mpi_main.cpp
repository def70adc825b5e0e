// SPDX-License-Identifier: BSD-3-Clause
// xview on several machines (MPI): the first rank is xview, the others scan parts of large maps and
// read and preprocess frames for it.
#include <fmt/core.h>
#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <exception>
#include <string>
#include <thread>
#include <vector>

#include "localizer/helper.h"
#include "narrative.h"
#include "process/atomic_file.h"
#include "process/library_chatter.h"
#include "tool.h"

namespace xview::tools {
namespace {

constexpr int kFirst = 0;                                 ///< the rank that is xview
constexpr std::uint64_t kPiece = std::uint64_t{1} << 30;  ///< of a message, whose count is an int

/// MPI itself waits by asking without pause, which takes a core from who works.
template <class IsDone>
void await(const IsDone& is_done) {
  while (!is_done()) std::this_thread::sleep_for(std::chrono::microseconds(100));
}

void awaitMessageFrom(int rank) {
  await([&] {
    int is_there = 0;
    MPI_Iprobe(rank, 0, MPI_COMM_WORLD, &is_there, MPI_STATUS_IGNORE);
    return is_there != 0;
  });
}

void send(const void* bytes, int count, MPI_Datatype type, int rank) {
  MPI_Request request;
  MPI_Isend(bytes, count, type, rank, 0, MPI_COMM_WORLD, &request);
  await([&] {
    int is_sent = 0;
    MPI_Test(&request, &is_sent, MPI_STATUS_IGNORE);
    return is_sent != 0;
  });
}

/// A message and its size. Whatever goes wrong in MPI ends all ranks (MPI_ERRORS_ARE_FATAL).
void sendTo(int rank, const std::string& message) {
  const std::uint64_t bytes = message.size();
  send(&bytes, 1, MPI_UINT64_T, rank);
  for (std::uint64_t at = 0; at < bytes; at += kPiece)
    send(message.data() + at, static_cast<int>(std::min(kPiece, bytes - at)), MPI_BYTE, rank);
}

std::string receiveFrom(int rank) {
  awaitMessageFrom(rank);
  std::uint64_t bytes = 0;
  MPI_Recv(&bytes, 1, MPI_UINT64_T, rank, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  std::string message(bytes, 0);
  for (std::uint64_t at = 0; at < bytes; at += kPiece)
    MPI_Recv(message.data() + at, static_cast<int>(std::min(kPiece, bytes - at)), MPI_BYTE, rank, 0,
             MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return message;
}

/// All ranks but the first, which are told to end with an empty request.
class OtherRanks final : public Helpers {
 public:
  OtherRanks() {
    MPI_Comm_size(MPI_COMM_WORLD, &ranks_);
    shareWork(this);
  }
  ~OtherRanks() override {
    shareWork(nullptr);
    for (int rank = 1; rank < ranks_; ++rank) sendTo(rank, "");
  }
  /// What went to and fro.
  std::string summary() const {
    return fmt::format("{} other ranks answered {} requests; {:.2f} MB to them, {:.2f} MB back",
                       count(), answers_, 1e-6 * static_cast<double>(sent_),
                       1e-6 * static_cast<double>(received_));
  }
  OtherRanks(const OtherRanks&) = delete;
  OtherRanks& operator=(const OtherRanks&) = delete;

  int count() const override { return ranks_ - 1; }
  void send(int helper, const std::string& request) override {
    sendTo(helper + 1, request);
    sent_ += request.size();
  }
  std::string receive(int helper) override {
    std::string answer = receiveFrom(helper + 1);
    received_ += answer.size();
    ++answers_;
    return answer;
  }

 private:
  int ranks_ = 1;
  std::size_t answers_ = 0, sent_ = 0, received_ = 0;  ///< requests, bytes
};

/// All ranks have the same arguments and see the same files.
void help(const std::vector<std::string>& arguments) {
  Helper helper([&] { return sharedRecordings(arguments); });
  for (std::string request = receiveFrom(kFirst); !request.empty(); request = receiveFrom(kFirst))
    sendTo(kFirst, helper.answer(request));
}

int runRank(int argc, char** argv) {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (rank == kFirst) {
    const OtherRanks others;
    const int code = runProgram(arguments);
    const auto is_asked = [](const std::string& a) { return a == "-v" || a == "--verbose"; };
    if (std::any_of(arguments.begin(), arguments.end(), is_asked))
      Narrative(Verbosity::verbose).detail(others.summary());
    return code;
  }
  try {
    help(arguments);
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
