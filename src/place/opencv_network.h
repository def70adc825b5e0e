// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "place/network.h"

/// The function of the module xview_network: Network::open(), which the caller is to delete.
extern "C" xview::Network* xviewOpenNetwork(const std::string& model_path,
                                            const xview::NetworkInput& input);
