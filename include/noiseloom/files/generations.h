// The generations of a run file: PATH, the newest; PATH.prev, the one before it; PATH.damaged, one that was put aside;
// PATH.tmp-..., one that is being written. Where PATH is a symbolic link, all of them stand beside its target, and the
// link stays.
//
// PATH is never absent once it was there: the old generation gets its second name, PATH.prev, by a hard link, and the
// new one takes the first by a rename. Where a file cannot have two names, PATH is missing for a moment between two
// renames; a run that is killed in it goes on from PATH.prev.
#pragma once

#include <memory>
#include <string>

#include "noiseloom/files/file_ops.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {

// The name of the generation before the one at `path`.
std::string previous_generation(const std::string& path);

// A name for a file that is being written for `path`: unique among hosts, processes and calls; short, as file systems
// bound the length of names.
std::string temporary_name(const std::string& path);

// Puts the complete and closed file `temporary` in the place of the newest generation, as said above. Where it throws,
// what was at `path` is still there, or the new file if only the last sync failed.
void publish_generation(FileOps& ops, const std::string& temporary, const std::string& path);

// For a run that goes on from PATH.prev because PATH is damaged or missing: moves what is at PATH to PATH.damaged and
// PATH.prev to PATH, so that the next checkpoint does not replace the one good generation by the damaged one.
void restore_previous_generation(FileOps& ops, const std::string& path);

// Removes temporary files that killed runs left beside `path`. Call with the lock held.
void remove_stale_temporaries(FileOps& ops, const std::string& path);

// Throws UserError if something is at `path` that is no run file, sound or damaged, and must not be replaced by one.
void refuse_foreign_output(const std::string& path);

// True where PATH is missing and PATH.prev is a run file: a run was interrupted in the moment described above, or
// somebody removed PATH. Whoever starts afresh there would lose the only copy.
bool only_previous_generation(const std::string& path);

// "; PATH.prev, the generation before it, is there", or "" where it is not: for messages about PATH.
std::string previous_generation_note(const std::string& path);

// The run file at PATH for programs that look at it and write nothing; it may have been changed by another program.
// Throws as RunFileReader does; where PATH is missing or damaged, with the note above.
RunFileReader open_to_look_at(const std::string& path);

struct NewestGeneration {
  std::unique_ptr<RunFileReader> reader;  // nullptr where neither generation is there
  bool is_previous = false;
  std::string trouble;  // why it is PATH.prev: what is wrong with PATH
};

// The newest good generation, checked throughout. PATH.prev stands in where PATH is missing or damaged. Throws
// UserError or EnvironmentError where that is no good either, or PATH is something else than a damaged run file;
// EnvironmentError where PATH cannot be read, twice: it may be whole, and PATH.prev would lose what came after it.
NewestGeneration open_newest_generation(const std::string& path, FileOps& ops = posix_file_ops());

}  // namespace noiseloom
