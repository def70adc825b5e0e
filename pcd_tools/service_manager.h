// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace xview::tools {

/// Tells the service manager that started the program (systemd, Type=notify) a line such as
/// "READY=1"; without one nothing is done.
void tellServiceManager(const char* what);

}  // namespace xview::tools
