// SPDX-License-Identifier: BSD-3-Clause
// Answers of `xview localize --json`. Those that are read are written and read again.
#include "answer.h"

#include "fuzz.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace xview;
  const std::string path =
      fuzz::written("in.jsonl", std::string(reinterpret_cast<const char*>(data), size));
  std::vector<tools::Answer> answers;
  if (!fuzz::isDone([&] { answers = tools::readAnswers(path); })) return 0;
  std::string text;
  for (const tools::Answer& answer : answers) text += tools::toJson(answer) + "\n";
  fuzz::isDone([&] {  // numbers that are not finite become null
    const auto again = tools::readAnswers(fuzz::written("out.jsonl", text));
    fuzz::require(again.size() == answers.size());
    for (std::size_t i = 0; i < again.size(); ++i)
      fuzz::require(again[i].last_frame == answers[i].last_frame &&
                    again[i].fix.status == answers[i].fix.status);
  });
  return 0;
}
