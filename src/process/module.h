// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace xview {

/// A function of a module: a library of xview that brings many others along and is therefore opened
/// when something is asked of it for the first time, never closed. It lies beside the program or
/// the library that asks, in the library folder of the installation, or in the run path of the
/// program. Throws Error that names the module and `use`, what it is for.
void* moduleFunction(const std::string& module, const char* function, const std::string& use);

}  // namespace xview
