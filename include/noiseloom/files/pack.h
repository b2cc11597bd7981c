// Many run files of one shape as one HDF5 file, for programs that want one array:
//
//   /samples            float32 [member, slice axes..., y, x, channel]
//   /pdf                float32 [member, slice axes..., y, x], where all members have one
//   /name, /checksum    text [member]: the members' names, the checksums of their /samples
//   /relative_error     float64 [member]; NaN where a member has none
//   /settings/<key>     float64 or text [member]: what differs from member to member
//
// The first two copied, so that the members may go afterwards, or as HDF5's virtual datasets, which read the members'
// files wherever these lie from the pack's folder; of a member that is gone they read NaN.
#pragma once

#include <string>
#include <vector>

namespace noiseloom {

struct PackMember {
  std::string name;
  std::string path;                 // of the run file
  std::vector<std::string> values;  // of the settings
};

enum class PackKind { copied, links };

// Writes the file `path`, which must not be there yet. Throws UserError where a member has another shape than the
// first; as RunFileReader does; EnvironmentError.
void pack_run_files(const std::string& path, const std::vector<PackMember>& members,
                    const std::vector<std::string>& settings, PackKind kind);

// Whether a file is such a one, by the names of what it holds; a run file is none. Throws EnvironmentError where an
// HDF5 file cannot be opened.
bool looks_like_pack(const std::string& path);

}  // namespace noiseloom
