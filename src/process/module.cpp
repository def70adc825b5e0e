// SPDX-License-Identifier: BSD-3-Clause
#include "process/module.h"

#include <dlfcn.h>

#include <filesystem>
#include <vector>

#include "process/library_chatter.h"
#include "xview/base/error.h"

namespace xview {
namespace {

namespace fs = std::filesystem;

/// The folder of the program or library that this code is part of.
fs::path ownFolder() {
  Dl_info info;
  const bool is_known = dladdr(reinterpret_cast<void*>(&ownFolder), &info) != 0 && info.dli_fname;
  std::error_code unknown;
  const fs::path program = fs::read_symlink("/proc/self/exe", unknown);
  const fs::path own = is_known ? fs::canonical(info.dli_fname, unknown) : fs::path();
  return (own.empty() ? program : own).parent_path();
}

std::vector<std::string> placesOf(const std::string& file) {
  const fs::path own = ownFolder();
  // A name without a folder is looked for in the run path.
  return {own / file, own / XVIEW_MODULES_FROM_BIN / file, own / "xview" / file,
          fs::path(XVIEW_MODULES_DIR) / file, file};
}

void* openModule(const std::string& file, const std::string& use) {
  const QuietLibraries quiet;
  std::string problem = "is missing";
  for (const std::string& path : placesOf(file)) {
    if (void* const opened = dlopen(path.c_str(), RTLD_LAZY | RTLD_LOCAL)) return opened;
    if (fs::exists(path)) problem = std::string("cannot be opened: ") + dlerror();
  }
  throw Error(file, problem + "; it is for " + use + "; expected beside the program or in " +
                        XVIEW_MODULES_DIR + ", where installing xview puts it");
}

}  // namespace

void* moduleFunction(const std::string& module, const char* function, const std::string& use) {
  const std::string file = module + ".so";
  void* const found = dlsym(openModule(file, use), function);
  if (!found) throw Error(file, std::string("is of another version: it has no ") + function);
  return found;
}

}  // namespace xview
