// SPDX-License-Identifier: BSD-3-Clause
#include "arguments.h"

#include "xview/options_file.h"
#include "xview/types/error.h"

namespace xview::bench {

std::vector<std::string> parseArguments(int argc, char** argv, const Flags& flags, Options& options,
                                        std::size_t least, const std::string& usage) {
  std::vector<std::string> operands;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word.rfind("--", 0) != 0) {
      operands.push_back(word);
      continue;
    }
    if (++i == argc) throw UsageError(word + " needs a value");
    const auto flag = flags.find(word);
    if (flag == flags.end())
      setOption(options, word.substr(2), argv[i]);
    else
      flag->second(argv[i]);
  }
  if (operands.size() < least) throw UsageError("usage: " + usage);
  return operands;
}

std::function<void(const std::string&)> into(double& number) {
  return [&number](const std::string& value) { number = std::stod(value); };
}

std::vector<std::string> words(const std::string& text) {
  std::vector<std::string> list;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ',');) list.push_back(word);
  return list;
}

}  // namespace xview::bench
