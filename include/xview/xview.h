// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Everything that a program of your own needs: read recordings, make maps, localize in them. The
// stages have headers of their own, in folders that are named after them.

#include "xview/base/budget.h"
#include "xview/base/error.h"
#include "xview/base/semantic_place.h"
#include "xview/cloud_recording.h"
#include "xview/io/cloud_files.h"
#include "xview/io/label_files.h"
#include "xview/io/pose_files.h"
#include "xview/io/recording.h"
#include "xview/localizer.h"
#include "xview/map/semantic_map.h"
#include "xview/mapper.h"
#include "xview/options.h"
#include "xview/place_builder.h"
#include "xview/sequence.h"
#include "xview/follower.h"
#include "xview/version.h"
