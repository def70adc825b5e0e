// SPDX-License-Identifier: BSD-3-Clause
#include "xview/types/localization.h"

namespace xview {

const char* toString(Status status) {
  switch (status) {
    case Status::accepted:
      return "accepted";
    case Status::ambiguous:
      return "ambiguous";
    case Status::rejected:
      return "rejected";
  }
  return "?";
}

const char* toString(Proposer proposer) { return proposer == Proposer::walks ? "walks" : "search"; }

}  // namespace xview
