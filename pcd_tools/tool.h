// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "localizer/helper.h"
#include "narrative.h"
#include "xview/base/budget.h"
#include "xview/options.h"

namespace CLI {
class App;
}

namespace xview::tools {

/// What the program tells its caller.
enum ExitCode {
  kDone = 0,
  kFailed = 1,  ///< bad file, full disk, anything outside the program
  kMisuse = 2,  ///< wrong flags or operands
  kNoPose = 3   ///< ran well, but no pose was accepted
};

/// How a sub-command presents itself. Operands are the arguments without a flag: inputs first,
/// output last.
struct Description {
  std::string name;      ///< "localize"
  std::string operands;  ///< "QUERY... MAP"
  std::string summary;   ///< one line for the list of commands
  std::string details;   ///< what a user must know, for --help
  std::string example;   ///< one line to copy
  std::size_t min_operands = 1;
  std::size_t max_operands = 1;
  bool writes_last = false;  ///< the last operand is the output, which -o may name as well
};

/// The flags of one sub-command: names like "--window" or "-o,--out FILE", where a word behind a
/// blank says what the value is, a variable that holds the default, and what it means.
class Flags {
 public:
  /// What a flag names that is written, as long as the variable lives.
  struct Output {
    std::string name;
    const std::string* path;
  };
  /// `group`: their headline in the help. `outputs`: of all flags so far.
  Flags(CLI::App& app, std::string group, std::vector<Output>& outputs)
      : app_(app), group_(std::move(group)), outputs_(outputs) {}
  void add(const std::string& names, bool& value, const std::string& help) const;
  void add(const std::string& names, int& value, const std::string& help) const;
  void add(const std::string& names, double& value, const std::string& help) const;
  void add(const std::string& names, std::string& value, const std::string& help) const;
  /// A file or folder that the command writes.
  void addOutput(const std::string& names, std::string& value, const std::string& help) const;
  /// The same for flags that only few need: --help-all lists them.
  Flags rare() const;

 private:
  template <class Value>
  void addValue(const std::string& names, Value& value, const std::string& help,
                const std::string& what) const;

  CLI::App& app_;
  std::string group_;
  std::vector<Output>& outputs_;
};

/// What a sub-command gets to work with.
struct Job {
  std::vector<std::string> operands;
  std::string command_line;  ///< as it was typed, for what the result is signed with
  Options options;           ///< defaults < --config files < flags
  BudgetLimits limits;       ///< of each query
  Narrative narrate;
};

/// One sub-command: declares its flags, then runs. Errors are thrown (Error, UsageError); nobody
/// but the wrapper catches what ends a run.
class Command {
 public:
  virtual ~Command() = default;
  virtual Description describe() const = 0;
  virtual void declare(Flags& flags) = 0;
  virtual ExitCode run(const Job& job) = 0;
  /// The recordings that run() shares with helpers (SharedRecordings), opened once more.
  virtual RecordingsOfMap recordings(const Job&) const { return {}; }
};

/// Parses, runs one of the commands, and turns whatever happens into an exit code and at most two
/// lines on stderr.
int runProgram(const std::vector<std::string>& arguments);
/// What the command of these arguments shares with helpers.
RecordingsOfMap sharedRecordings(std::vector<std::string> arguments);
/// As a shell would take it again.
std::string commandLine(const std::vector<std::string>& arguments);

// Every sub-command lives in the file of its name.
std::unique_ptr<Command> makeDemo();
std::unique_ptr<Command> makeSimulate();
std::unique_ptr<Command> makeInfo();
std::unique_ptr<Command> makeLabel();
std::unique_ptr<Command> makeLift();
std::unique_ptr<Command> makeBlobs();
std::unique_ptr<Command> makeGraph();
std::unique_ptr<Command> makeMap();
std::unique_ptr<Command> makeMatch();
std::unique_ptr<Command> makeLocalize();
std::unique_ptr<Command> makeFollow();
std::unique_ptr<Command> makeServe();
std::unique_ptr<Command> makeLookalikes();
std::unique_ptr<Command> makeDiff();
std::unique_ptr<Command> makeEvaluate();
std::unique_ptr<Command> makeFuse();
std::unique_ptr<Command> makePrune();
std::unique_ptr<Command> makeLearn();
std::unique_ptr<Command> makeView();

}  // namespace xview::tools
