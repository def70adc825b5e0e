// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "xview/base/localization.h"
#include "xview/base/semantic_place.h"

namespace xview {

class StoredCloud;
class StoredVertices;
class StoredView;
namespace search {
struct MapOverview;
}  // namespace search

}  // namespace xview

namespace xview::map {

constexpr int kMapSchemaVersion = 4;  ///< of map files

/// A stretch of a map that was looked for in it, with the noise of a usual query.
struct OwnStretch {
  double window_m = 0;    ///< path length along it [m]
  double confidence = 0;  ///< of such a query by its place alone, before points are registered
};

class PackedVertices;

/// A place that is kept in a file, to localize in. Its poses, frames and stamps are key frames.
struct SemanticMap : Place {
  std::vector<std::uint32_t> source_of_pose;  ///< per key frame, a position in `sources`
  std::vector<std::string> sources;           ///< inputs it was built from, in order
  std::string program_version;                ///< that wrote the file it comes from
  std::uint64_t checksum = 0;                 ///< of what that file holds; 0 = it is of none
  std::string options_yaml;                   ///< effective options of the last build
  std::vector<WrongPlace>
      wrong_places;  ///< of some of its own stretches; see measureNullHypothesis
  std::vector<OwnStretch> own_stretches;    ///< these stretches at their own places
  search::PathNull null;                    ///< of its path; see measureNullHypothesis
  std::optional<pose::SurfaceNoise> noise;  ///< of its points, in canonical lengths
  /// The vertices of `graph` as its file has them, if they come from one.
  std::shared_ptr<const PackedVertices> packed_vertices;
  /// Of the view, if that is large; see map/contents.h.
  std::shared_ptr<const search::MapOverview> overview;
  /// Points that are not in `cloud`, if any, in canonical lengths; see openMap.
  std::shared_ptr<const StoredCloud> stored_points;
  /// In place of what `bev` holds, which is without samples and seen cells then; see
  /// openMap.
  std::shared_ptr<const StoredView> stored_view;
  /// In place of the vertices of `graph`, which has none then; see openMap.
  std::shared_ptr<const StoredVertices> stored_vertices;

  void addKeyframe(const Eigen::Isometry3d& T_map_sensor, std::int64_t frame, double stamp_s,
                   std::uint32_t source) {
    poses.push_back(T_map_sensor);
    frames.push_back(frame);
    stamps_s.push_back(stamp_s);
    source_of_pose.push_back(source);
  }
};

/// A map for whoever wants a shared one (Localizer), kept by the caller: it must outlive all that
/// hold the pointer.
inline std::shared_ptr<const SemanticMap> borrowed(const SemanticMap& map) {
  return {std::shared_ptr<const SemanticMap>(), &map};
}

/// True if the file starts like an .xvm database (SQLite magic and our application_id); false for
/// anything else, also missing.
bool isMapFile(const std::string& path);

/// Writes the whole map in one transaction. A new file appears only when complete (written beside,
/// then renamed); an existing map is replaced inside one transaction, so that a killed process
/// leaves the old map or the new one. A file that is no map, or a map of another schema version, is
/// not overwritten. Throws Error; the file is then as before.
///
/// Vertices, edges, key frames, labels and texts are kept exactly. BEV grid and cloud are rounded
/// to 1 cm relative to their origins and come back in the order of their tiles; points that are not
/// finite are dropped, and so are their ranges. The same map gives the same bytes in a new file.
void saveMap(const std::string& path, const SemanticMap& map);

/// What was added to a map, in its frame.
struct Visit {
  SemanticMap place;
  double sigma_m = 0;  ///< standard deviation of where it was put
};

/// A change of a map that can be undone.
struct Revision {
  std::string note;       ///< what was done
  bool is_visit = false;  ///< something was added, which loadVisit() reads
};

/// Replaces an existing map like saveMap, but keeps what changes, so that undoRevision brings the
/// former map back. `note` says what was done; `visit`, if any, is what was added, and kept too.
void saveRevision(const std::string& path, const SemanticMap& map, const std::string& note,
                  const Visit* visit = nullptr);

/// Several such changes of a map file in one transaction: all of them, or none. No other program
/// writes the map from the first change on.
class MapChanges {
 public:
  explicit MapChanges(std::string path);
  ~MapChanges();  ///< what was not committed is taken back
  MapChanges(MapChanges&&) noexcept;

  /// The parameters of saveRevision(). Throws Error; then nothing must follow.
  void add(const SemanticMap& map, const std::string& note, const Visit* visit = nullptr);
  void commit();  ///< throws Error; the file is then as before

 private:
  struct Connection;
  std::string path_;
  std::unique_ptr<Connection> connection_;
};

/// Replaces an existing map by that of another file, with the changes on its record, in one
/// transaction. Throws Error; the file is then as before.
void replaceMap(const std::string& path, const std::string& other);

/// The changes since the last saveMap, oldest first. Throws Error.
std::vector<Revision> readRevisions(const std::string& path);

/// What the change at that position added. Throws Error, also if it added nothing.
Visit loadVisit(const std::string& path, std::size_t revision);

/// Takes back the last saveRevision that was not followed by saveMap, in one transaction. False if
/// there is none. Throws Error.
bool undoRevision(const std::string& path);

/// A map as its file has it: of one of canonical scale the points stay packed until those of a
/// place are asked for (`stored_points`), and so do the vertices, if their edges are those of a
/// radius (`stored_vertices`), and the bird's-eye view of a large one (`stored_view`). A Localizer
/// takes such a map, appendToMap() grows it, saveMap() writes it, unpacked() has all of it in
/// memory for whoever reads `cloud`, `graph` or `bev` as they are. The file is opened for reading
/// only. Throws Error: missing, not a map, another schema version (the message names both),
/// damaged.
SemanticMap openMap(const std::string& path);

/// The same map with all of it in `cloud`, `graph` and `bev`. Throws Error if its file was damaged.
SemanticMap unpacked(SemanticMap map);

/// Held from reading a map to writing it back, so that two programs that add to it at one time add
/// one after the other, and neither loses what the other added. The constructor waits for whoever
/// holds it. A map that does not exist or lies on a file system without locks is not held.
/// Reading a map needs no lock.
class MapLock {
 public:
  explicit MapLock(const std::string& path);
  ~MapLock();
  MapLock(const MapLock&) = delete;
  MapLock& operator=(const MapLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace xview::map
