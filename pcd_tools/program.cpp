// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <new>
#include <system_error>
#include <utility>

#include "base/user_text.h"
#include "manual.h"
#include "outputs.h"
#include "process/atomic_file.h"
#include "process/library_chatter.h"
#include "terminal.h"
#include "tool.h"
#include "xview/base/error.h"
#include "xview/options.h"

namespace xview::tools {
namespace {

using CommandMaker = std::unique_ptr<Command> (*)();
constexpr CommandMaker kCommands[] = {
#ifdef XVIEW_WITH_SIM
    makeDemo,       makeSimulate,
#endif
    makeInfo,       makeLabel,    makeLift,     makeBlobs, makeGraph, makeMap,   makeMatch,
    makeLocalize,   makeFollow,
#ifdef XVIEW_WITH_SERVE
    makeServe,
#endif
    makeLookalikes, makeDiff,     makeEvaluate, makeFuse,  makePrune, makeLearn, makeView};

/// What every command understands.
struct CommonFlags {
  std::vector<std::string> configs;
  std::map<std::string, std::string> values;  ///< option key -> text, for the keys that were given
  bool print_config = false, quiet = false, verbose = false;
};

std::string withDefault(const std::string& help, const std::string& fallback) {
  return fallback.empty() ? help : fmt::format("{} (default {})", help, fallback);
}

const std::string kFile = "FILE";  ///< what a flag takes that names one
const std::string kCommon = "Common flags", kRare = "More flags", kStage = "Options of ";

/// What a default of 0 means is told in the words of the help.
template <class Number>
std::string withDefault(const std::string& help, Number fallback) {
  return withDefault(help, fallback == 0 ? std::string() : fmt::format("{}", fallback));
}

/// The usage in our own words and the flags in two columns, fitted to the terminal. --help leaves
/// out what only few need, --help-all nothing.
class HelpText final : public CLI::FormatterBase {
 public:
  explicit HelpText(std::string usage) : usage_(std::move(usage)) {}

  std::string make_help(const CLI::App* app, std::string, CLI::AppFormatMode mode) const override {
    const bool is_all = mode == CLI::AppFormatMode::All;
    std::string text = usage_ + "\n";
    std::size_t left_out = 0;
    for (const std::string& group : app->get_groups()) {
      const auto options =
          app->get_options([&](const CLI::Option* option) { return option->get_group() == group; });
      if (group.empty() || options.empty()) continue;
      if (!is_all && (group == kRare || group.rfind(kStage, 0) == 0)) {
        left_out += options.size();
        continue;
      }
      text += "\n" + inked(group + ":", Ink::bold, stdout) + "\n";
      for (const CLI::Option* option : options) text += lineOf(*option);
    }
    if (left_out > 0) text += fmt::format("\n--help-all lists {} more.\n", left_out);
    return text;
  }

 private:
  static std::string lineOf(const CLI::Option& option) {
    constexpr std::size_t kNames = 24;
    const bool has_value = option.get_expected_min() > 0;
    std::string names = "  " + option.get_name(false, true);
    if (has_value) names += " " + option.get_type_name();
    const std::string gap = columnsOf(names) < kNames ? "" : "\n" + std::string(kNames, ' ');
    return padded(names, kNames) + (gap.empty() ? "" : gap) +
           wrapped(option.get_description(), textWidth(stdout) - kNames, kNames) + "\n";
  }

  std::string usage_;
};

/// One flag per key of the options, grouped by stage; those of stages may be left out of the help.
void declareOptions(CLI::App& app, CommonFlags& common, bool listed) {
  for (const OptionEntry& entry : listOptions(Options{})) {
    const std::size_t dot = entry.key.rfind('.');
    std::string group = entry.key == "threads" ? kCommon : kRare;
    if (dot != std::string::npos) group = listed ? kStage + entry.key.substr(0, dot) : "";
    const auto store = [&common, key = entry.key](const std::string& text) {
      common.values[key] = text;
    };
    app.add_option_function<std::string>("--" + entry.key, store,
                                         withDefault(entry.help, entry.fallback))
        ->group(group)
        ->type_name("VALUE");
  }
}

void declareCommon(CLI::App& app, CommonFlags& common, bool list_options) {
  app.add_option("--config", common.configs,
                 "options from a YAML file, or one of paper/...; may be repeated")
      ->group(kCommon)
      ->type_name("FILE")
      ->expected(1)
      ->allow_extra_args(false)  // else it would swallow the operands behind it
      ->take_all();
  app.add_flag("-q,--quiet", common.quiet, "say nothing on stderr but errors")->group(kCommon);
  app.add_flag("-v,--verbose", common.verbose, "say more on stderr")->group(kCommon);
  app.set_help_flag("-h,--help", "print this text")->group(kCommon);
  app.set_help_all_flag("--help-all", "print it with every option, its unit and default")
      ->group(kCommon);
  app.add_flag("--print-config", common.print_config,
               "print the effective options as YAML and stop")
      ->group(kRare);
  app.set_version_flag("--version", "xview " XVIEW_VERSION)
      ->description("print the version")
      ->group(list_options ? kRare : kCommon);
  declareOptions(app, common, list_options);
}

std::vector<std::string> namesOfFlags(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

/// Flags are known by either of - and _ between their words; those of others stay as they are.
void spellAsDeclared(std::vector<std::string>& arguments, const CLI::App& app) {
  const auto hyphenated = [](std::string name) {
    std::replace(name.begin(), name.end(), '_', '-');
    return name;
  };
  std::map<std::string, std::string> declared;
  for (const std::string& name : namesOfFlags(app)) declared[hyphenated(name)] = name;
  for (std::string& argument : arguments) {
    if (argument == "--") return;
    const std::size_t end = std::min(argument.find('='), argument.size());
    const auto known = declared.find(hyphenated(argument.substr(0, end)));
    if (known != declared.end()) argument.replace(0, end, known->second);
  }
}

/// Flags that nobody declared end up among the remaining arguments of CLI11, as do operands.
std::vector<std::string> takeOperands(const CLI::App& app) {
  std::vector<std::string> operands = app.remaining();
  for (const std::string& operand : operands) {
    if (operand == "--") break;  // what follows is no flag
    if (operand.size() < 2 || operand[0] != '-') continue;
    const std::string name = operand.substr(0, operand.find('='));
    throw UsageError("unknown flag " + name + knownWordsHint(name, namesOfFlags(app)));
  }
  operands.erase(std::remove(operands.begin(), operands.end(), "--"), operands.end());
  return operands;
}

void checkOperands(const Description& about, const std::vector<std::string>& operands) {
  if (operands.size() >= about.min_operands && operands.size() <= about.max_operands) return;
  std::string found;
  for (const std::string& operand : operands) found += " " + operand;
  throw UsageError(fmt::format("xview {} needs {}, found {}{}", about.name, about.operands,
                               operands.size(), found.empty() ? "" : ":" + found));
}

Options effectiveOptions(const CommonFlags& common) {
  Options options;
  for (const std::string& path : common.configs) applyOptionsFile(options, path);
  for (const auto& [key, value] : common.values) setOption(options, key, value);
  return options;
}

Verbosity verbosityOf(const CommonFlags& common) {
  if (common.quiet) return Verbosity::quiet;
  return common.verbose ? Verbosity::verbose : Verbosity::normal;
}

/// Parses into `common` and the flags of the command; false if --help or --version was answered.
bool parse(CLI::App& app, std::vector<std::string> arguments) {
  app.allow_extras();
  spellAsDeclared(arguments, app);
  std::reverse(arguments.begin(), arguments.end());  // CLI11 pops from the back
  try {
    app.parse(std::move(arguments));
  } catch (const CLI::Success& answered) {
    app.exit(answered);
    return false;
  } catch (const CLI::ParseError& e) {
    throw UsageError(oneLine(e.what()));
  }
  return true;
}

std::string usageOf(const Description& about) {
  const std::size_t width = textWidth(stdout);
  return wrapped(fmt::format("Usage: xview {} {} [FLAGS]", about.name, about.operands), width) +
         "\n" + wrapped("Example: " + about.example, width) + "\n\n" +
         wrapped(fmt::format("{}: {}{} {}", about.name, about.summary,
                             about.summary.back() == '?' ? "" : ".", oneLine(about.details)),
                 width);
}

bool isSameFile(const std::string& path, const std::string& other) {
  std::error_code none;  // what does not exist is no other file
  return std::filesystem::equivalent(path, other, none);
}

/// A file that is named by a flag is hardly what the command reads as well: an answer would be
/// written over the map, or a recording.
void requireOtherFiles(const CLI::App& app, const std::vector<std::string>& operands) {
  for (const CLI::Option* flag : app.get_options()) {
    if (flag->get_type_name() != kFile) continue;
    for (const std::string& path : flag->results()) {
      std::error_code none;
      if (!std::filesystem::is_regular_file(path, none)) continue;  // a word may be a folder, too
      for (const std::string& operand : operands) {
        if (isSameFile(path, operand))
          throw UsageError(fmt::format("{} {} is an operand, too; give it a path of its own",
                                       flag->get_name(), path));
      }
    }
  }
}

void requireOtherOutput(const std::vector<std::string>& operands) {
  const std::vector<std::string> inputs(operands.begin(), operands.end() - 1);
  const std::string& output = operands.back();
  for (const std::string& input : inputs) {
    if (isSameFile(input, output))
      throw UsageError(output +
                       " is what is read and would be written over; give the output a path of its "
                       "own");
    if (liesIn(input, output))
      throw UsageError(
          fmt::format("{} holds {}, which is read and could be written over; give the "
                      "output a path of its own",
                      output, input));
  }
  requireOutside("", output, inputs);
}

/// A command with all its flags.
struct Declared {
  explicit Declared(std::unique_ptr<Command> made)
      : command(std::move(made)), about(command->describe()) {
    Flags flags(app, "Flags of xview " + about.name, outputs);
    command->declare(flags);
    if (about.writes_last) flags.add("-o,--out", out, "the output, if it is not the last operand");
    declareCommon(app, common, true);
  }

  std::unique_ptr<Command> command;
  Description about;
  CLI::App app;
  std::vector<Flags::Output> outputs;
  std::string out;
  CommonFlags common;
};

/// Of flags that were parsed.
Job jobOf(const Declared& declared) {
  Job job;
  job.operands = takeOperands(declared.app);
  requireOtherFiles(declared.app, job.operands);
  for (const Flags::Output& output : declared.outputs) {
    if (*output.path == "-")
      throw UsageError(output.name +
                       " -: expected the path of a file; to stdout goes what a command prints "
                       "without -o");
    requireOutside(output.name, *output.path, job.operands);
  }
  if (!declared.out.empty()) job.operands.push_back(declared.out);
  job.options = effectiveOptions(declared.common);
  job.narrate = Narrative(verbosityOf(declared.common));
  return job;
}

int runCommand(Declared& declared, const std::vector<std::string>& arguments,
               const std::string& command_line) {
  auto& [command, about, app, outputs, out, common] = declared;
  app.formatter(std::make_shared<HelpText>(usageOf(about)));
  if (!parse(app, arguments)) return kDone;
  Job job = jobOf(declared);
  job.command_line = command_line;
  if (common.print_config) {
    fmt::print("{}", toYaml(job.options));
    return kDone;
  }
  checkOperands(about, job.operands);
  if (about.writes_last) requireOtherOutput(job.operands);
  return command->run(job);
}

/// xview without a command, which helps.
int runWithoutCommand(const std::vector<Description>& commands,
                      std::vector<std::string> arguments) {
  if (!arguments.empty() && (arguments[0] == "simulate" || arguments[0] == "demo"))
    throw UsageError(
        "this build has no simulator: Embree was not found; install libembree-dev and build again");
  if (!arguments.empty() && arguments[0] == "serve")
    throw UsageError(
        "this build has no server: cpp-httplib was not found; install libcpp-httplib-dev and build "
        "again");
  std::string list;
  std::vector<std::string> names;
  for (const Description& about : commands) {
    list +=
        fmt::format("\n  {:<11}{}", about.name, wrapped(about.summary, textWidth(stdout) - 13, 13));
    names.push_back(about.name);
  }
  CLI::App app;
  app.formatter(std::make_shared<HelpText>(
      "xview finds where a robot is in a semantic map, from any view-point.\n\nUsage: xview "
      "COMMAND ... [FLAGS]\nExample: xview localize town/rear --window 60 town.xvm\n\nCommands:" +
      list + "\n\nxview COMMAND --help explains one, xview help options their options."));
  CommonFlags common;
  declareCommon(app, common, false);
  if (arguments.empty()) arguments = {"--help"};
  if (!parse(app, arguments)) return kDone;
  const std::vector<std::string> operands = takeOperands(app);
  if (!operands.empty())
    throw UsageError("unknown command " + operands[0] + knownWordsHint(operands[0], names));
  if (!common.print_config) throw UsageError("no command given");
  fmt::print("{}", toYaml(effectiveOptions(common)));
  return kDone;
}

/// Where the name of a command stands: first, or behind common flags and their values.
bool isCommandAt(const std::vector<std::string>& arguments, std::size_t position) {
  const auto is_flag = [&](std::size_t i) {
    return !arguments[i].empty() && arguments[i][0] == '-';
  };
  for (std::size_t i = 0; i < position; ++i) {
    if (!is_flag(i) && (i == 0 || !is_flag(i - 1))) return false;
  }
  return position < arguments.size();
}

/// xview help --write DIR: the pages of man and the completion for bash, for packages.
int writeManual(const std::string& folder) {
  std::vector<std::unique_ptr<Declared>> declared;
  std::vector<CommandText> texts;
  for (const CommandMaker make : kCommands) {
    declared.push_back(std::make_unique<Declared>(make()));
    texts.push_back({declared.back()->about, &declared.back()->app});
  }
  const std::string pages = folder + "/man1/", completions = folder + "/completions/";
  makeFolder(pages);
  makeFolder(completions);
  for (const CommandText& text : texts)
    writeFile(pages + "xview-" + text.about.name + ".1", manPage(text));
  writeFile(pages + "xview.1", manPage(texts));
  writeFile(completions + "xview", bashCompletion(texts));
  return kDone;
}

/// xview help options: those that all commands have, once.
int printOptions() {
  CLI::App app;
  app.set_help_flag();
  CommonFlags common;
  declareOptions(app, common, true);
  app.formatter(std::make_shared<HelpText>(
      "What stages can be told: every command as --KEY VALUE, and files of --config\nas YAML, of "
      "which `xview --print-config` prints one."));
  fmt::print("{}", app.help("", CLI::AppFormatMode::All));
  return kDone;
}

/// The command that is named, whose name leaves the arguments; null if there is none. `known`
/// receives the descriptions of all up to it.
std::unique_ptr<Command> takeCommand(std::vector<std::string>& arguments,
                                     std::vector<Description>& known) {
  for (const CommandMaker make : kCommands) {
    std::unique_ptr<Command> command = make();
    known.push_back(command->describe());
    const auto found = std::find(arguments.begin(), arguments.end(), known.back().name);
    if (!isCommandAt(arguments, static_cast<std::size_t>(found - arguments.begin()))) continue;
    arguments.erase(found);
    return command;
  }
  return nullptr;
}

/// Runs one of the commands; `called` gets its name behind a blank.
int dispatch(std::vector<std::string> arguments, std::string& called) {
  const std::string command_line = commandLine(arguments);
  bool wants_help = false;
  if (!arguments.empty() && arguments[0] == "help") {  // xview help [COMMAND|options]
    arguments.erase(arguments.begin());
    wants_help = true;
    if (arguments.size() == 2 && arguments[0] == "--write") return writeManual(arguments[1]);
    if (arguments == std::vector<std::string>{"options"}) return printOptions();
  }
  std::vector<Description> known;
  std::unique_ptr<Command> command = takeCommand(arguments, known);
  if (!command) return runWithoutCommand(known, arguments);
  called = " " + known.back().name;
  if (wants_help) arguments = {"--help"};
  Declared declared(std::move(command));
  return runCommand(declared, arguments, command_line);
}

/// A full disk shows when the last results leave the program.
void flushResults() {
  if (std::fflush(stdout) != 0 || std::ferror(stdout))
    throw Error("standard output", "cannot be written");
}

/// Memory of a frame serves the next one: given back and asked for again, the system would clear
/// its pages each time, which took up to half of the time of mapping raw camera images.
void keepFreedMemory() {
#ifdef __GLIBC__
  constexpr int kAlone_bytes = 32 << 20;  // blocks from here on; glibc allows no more
  constexpr int kKept_bytes = 64 << 20;
  mallopt(M_MMAP_THRESHOLD, kAlone_bytes);
  mallopt(M_TRIM_THRESHOLD, kKept_bytes);
#endif
}

}  // namespace

RecordingsOfMap sharedRecordings(std::vector<std::string> arguments) {
  std::vector<Description> known;
  std::unique_ptr<Command> command = takeCommand(arguments, known);
  if (!command) return {};
  Declared declared(std::move(command));
  if (!parse(declared.app, arguments)) return {};
  Job job = jobOf(declared);
  job.narrate = Narrative(Verbosity::quiet);
  return declared.command->recordings(job);
}

std::string commandLine(const std::vector<std::string>& arguments) {
  std::string line = "xview";
  for (const std::string& word : arguments) {
    const bool is_plain =
        !word.empty() && word.find_first_of(" \t\n\"'\\$`*?[]{}()<>|&;#~!") == std::string::npos;
    std::string quoted;
    for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += " " + (is_plain ? word : "'" + quoted + "'");
  }
  return line;
}

int runProgram(const std::vector<std::string>& arguments) {
  keepFreedMemory();
  const Narrative narrate;
  std::string called;
  try {
    const int code = dispatch(arguments, called);
    flushResults();
    return code;
  } catch (const UsageError& e) {
    narrate.error(e.what());
    printToUser(fmt::format("see: xview{} --help\n", called));
    return kMisuse;
  } catch (const std::bad_alloc&) {
    narrate.error("out of memory; fewer --frames or a shorter --window need less");
  } catch (const std::system_error& e) {
    narrate.error(e.code() == std::errc::resource_unavailable_try_again
                      ? std::string("cannot start a thread: ") + e.what() +
                            "; --threads 1 needs fewer, `ulimit -u` and `ulimit -v` show the limits"
                      : e.what());
  } catch (const std::exception& e) {
    narrate.error(e.what());
  }
  return kFailed;
}

void Flags::add(const std::string& names, bool& value, const std::string& help) const {
  app_.add_flag(names, value, help)->group(group_);
}
/// `what`: the value, if `names` do not say it.
template <class Value>
void Flags::addValue(const std::string& names, Value& value, const std::string& help,
                     const std::string& what) const {
  const std::size_t blank = names.find(' ');
  app_.add_option(names.substr(0, blank), value, withDefault(help, value))
      ->group(group_)
      ->type_name(blank == std::string::npos ? what : names.substr(blank + 1));
}
void Flags::add(const std::string& names, int& value, const std::string& help) const {
  addValue(names, value, help, "N");
}
void Flags::add(const std::string& names, double& value, const std::string& help) const {
  addValue(names, value, help, "X");
}
void Flags::add(const std::string& names, std::string& value, const std::string& help) const {
  addValue(names, value, help, kFile);
}
void Flags::addOutput(const std::string& names, std::string& value, const std::string& help) const {
  add(names, value, help);
  const std::string name = names.substr(0, names.find(' '));
  outputs_.push_back({name.substr(name.find("--")), &value});
}
Flags Flags::rare() const { return {app_, kRare, outputs_}; }

}  // namespace xview::tools
