// SPDX-License-Identifier: BSD-3-Clause
#include "manual.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <map>

#include "base/option_field.h"
#include "base/option_visits.h"

namespace xview::tools {
namespace {

/// Text for roff: no character of it is a request, and a hyphen is one that can be searched for.
std::string roff(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\\')
      escaped += "\\e";
    else if (c == '-')
      escaped += "\\-";
    else
      escaped += c;
  }
  return !escaped.empty() && (escaped[0] == '.' || escaped[0] == '\'') ? "\\&" + escaped : escaped;
}

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

std::string headOf(const std::string& page, const std::string& summary) {
  return fmt::format(".TH {} 1 \"\" \"xview {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n",
                     upper(roff(page)), XVIEW_VERSION, roff(page), roff(summary));
}

bool takesValue(const CLI::Option& option) { return option.get_expected_min() > 0; }

std::string flagsOf(const CLI::App& app) {
  std::string text;
  for (const std::string& group : app.get_groups()) {
    const auto options =
        app.get_options([&](const CLI::Option* option) { return option->get_group() == group; });
    if (group.empty() || options.empty()) continue;
    text += ".SS " + roff(group) + "\n";
    for (const CLI::Option* option : options) {
      text += ".TP\n\\fB" + roff(option->get_name(false, true)) + "\\fR";
      if (takesValue(*option)) text += " \\fI" + roff(option->get_type_name()) + "\\fR";
      text += "\n" + roff(option->get_description()) + "\n";
    }
  }
  return text;
}

constexpr const char* kExitStatus =
    ".SH EXIT STATUS\n.TP\n0\ndone\n.TP\n1\nfailed: a bad file, a full disk\n.TP\n2\n"
    "wrong use\n.TP\n3\nran well, but no pose was accepted\n";

/// What flags may be set to, by their names, where that is a list of words.
std::map<std::string, std::string> wordsOfFlags() {
  std::map<std::string, std::string> words;
  Options options;
  for (const OptionField& field : fieldsOf(options)) {
    const auto* choices = std::get_if<Choices>(&field.rule);
    if (choices == nullptr) continue;
    std::string& list = words["--" + field.key];
    for (const std::string& value : choices->values) list += (list.empty() ? "" : " ") + value;
  }
  return words;
}

std::string flagNames(const CLI::App& app) {
  std::string names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames())
      names += (names.empty() ? "--" : " --") + name;
  }
  return names;
}

}  // namespace

std::string manPage(const CommandText& command) {
  const Description& about = command.about;
  return headOf("xview-" + about.name, about.summary) +
         fmt::format(".SH SYNOPSIS\n\\fBxview {}\\fR {} [\\fIFLAGS\\fR]\n", roff(about.name),
                     roff(about.operands)) +
         ".SH DESCRIPTION\n" + roff(about.details) + "\n.SH OPTIONS\n" + flagsOf(*command.app) +
         kExitStatus + ".SH EXAMPLE\n" + roff(about.example) + "\n.SH SEE ALSO\n\\fBxview\\fR(1)\n";
}

std::string manPage(const std::vector<CommandText>& commands) {
  std::string text =
      headOf("xview", "find where a robot is in a semantic map") +
      ".SH SYNOPSIS\n\\fBxview\\fR \\fICOMMAND\\fR ... [\\fIFLAGS\\fR]\n.SH DESCRIPTION\n"
      "xview turns depth images, scans or clouds into a graph of things and finds it in the graph "
      "of a map, from any view\\-point. The answer is a pose with a covariance, or a refusal with "
      "its reason.\n.SH COMMANDS\n";
  std::string pages;
  for (const CommandText& command : commands) {
    text += ".TP\n\\fB" + roff(command.about.name) + "\\fR\n" + roff(command.about.summary) + "\n";
    pages += (pages.empty() ? "" : ",\n") +
             fmt::format("\\fBxview\\-{}\\fR(1)", roff(command.about.name));
  }
  return text + kExitStatus + ".SH SEE ALSO\n" + pages + "\n";
}

std::string bashCompletion(const std::vector<CommandText>& commands) {
  std::string names, flags, values;
  for (const CommandText& command : commands) {
    names += (names.empty() ? "" : " ") + command.about.name;
    flags += fmt::format("    {}) flags=\"{}\" ;;\n", command.about.name, flagNames(*command.app));
  }
  for (const auto& [flag, words] : wordsOfFlags())
    values +=
        fmt::format("    {}) mapfile -t COMPREPLY < <(compgen -W \"{}\" -- \"$word\"); return ;;\n",
                    flag, words);
  return R"(# bash completion for xview, made of the flags that `xview COMMAND --help-all` prints.
_xview() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command='' flags='' other
  local commands=")" +
         names + R"("
  for other in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    if [[ " $commands " == *" $other "* ]]; then command=$other; break; fi
  done
  case $before in
)" + values +
         R"(  esac
  case $command in
    '') mapfile -t COMPREPLY < <(compgen -W "help $commands" -- "$word"); return ;;
)" + flags +
         R"(  esac
  if [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$flags" -- "$word")
  else
    compopt -o filenames
    mapfile -t COMPREPLY < <(compgen -f -- "$word")
  fi
}
complete -F _xview xview
)";
}

}  // namespace xview::tools
