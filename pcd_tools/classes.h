// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "base/label_match.h"
#include "narrative.h"
#include "xview/io/recording.h"

namespace xview::tools {

/// Says which roles and kinds of classes are guesses, as nobody gave them.
void logGuesses(const std::string& path, const LabelSet& labels, const Narrative& narrate);

/// Says how the classes of a recording meet those of options.map_labels, if they are given.
void tellHowClassesMeet(const std::string& path, const LabelSet& labels,
                        const io::InputOptions& options, const Narrative& narrate);
/// The same of what is in memory, and which classes of its vertices have no partner.
void tellHowClassesMeet(const std::string& path, const Place& place,
                        const io::InputOptions& options, const Narrative& narrate);

/// What is added to a map: the recording in the classes of options.map_labels, if they are given
/// and any class of it can be found there. Classes of shapes stay, which meet those of a map by
/// kind. A Localizer takes queries in their own classes.
std::unique_ptr<FrameSource> inClassesOfMap(std::unique_ptr<FrameSource> source,
                                            const io::InputOptions& options);
/// The same for what is in memory.
Place inClassesOfMap(Place place, const io::InputOptions& options);

/// The classes of a graph file that names `own` or none: those chosen, those of classes.yaml beside
/// it, those of the map if it knows nearly all ids (a guess, which is said), else generic ones.
LabelSet labelsOfGraph(const std::string& path, const SemanticGraph& graph,
                       const std::optional<LabelSet>& own, const io::InputOptions& options,
                       const Narrative& narrate);

}  // namespace xview::tools
