// SPDX-License-Identifier: BSD-3-Clause
// Texts of lines: class names, likelihoods, verdict models; and priors as users write them.
#include "base/user_text.h"
#include "fuzz.h"
#include "search/likelihoods.h"
#include "verdict/verdict.h"
#include "xview/io/label_files.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace xview;
  const std::string text(reinterpret_cast<const char*>(data), size);
  const std::string path = fuzz::written("in.txt", text);
  fuzz::isDone([&] { io::readClassNames(path); });
  fuzz::isDone([&] {
    const search::LikelihoodTable table = search::parseLikelihoods(text, path);
    const std::string again = search::toText(table);
    fuzz::require(search::toText(search::parseLikelihoods(again, path)) == again);
  });
  fuzz::isDone([&] { verdict::readVerdictModel(path); });
  fuzz::isDone([&] { parseCircle("--near", text); });
  fuzz::isDone([&] { parseHeading("--yaw", text); });
  fuzz::isDone([&] { parseScale("--scale", text); });
  for (const char c : printable(text)) fuzz::require(static_cast<unsigned char>(c) >= 0x20);
  return 0;
}
