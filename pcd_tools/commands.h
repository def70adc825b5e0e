// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "tool.h"

namespace xview::tools {

std::unique_ptr<Command> makeSimulate();
std::unique_ptr<Command> makeInfo();
std::unique_ptr<Command> makeLift();
std::unique_ptr<Command> makeBlobs();
std::unique_ptr<Command> makeGraph();
std::unique_ptr<Command> makeMap();
std::unique_ptr<Command> makeMatch();
std::unique_ptr<Command> makeLocalize();
std::unique_ptr<Command> makeEvaluate();
std::unique_ptr<Command> makeFuse();
std::unique_ptr<Command> makeLearn();
std::unique_ptr<Command> makeView();

}  // namespace xview::tools
