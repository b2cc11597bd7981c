// Standard output as a place where writing can fail: on a full disk, a closed descriptor.
#pragma once

namespace noiseloom {

// To be called before any file is opened. Where a standard stream was closed by the caller (`>&-`), its descriptor is
// taken by something that cannot be written, so that no file that is opened later receives what is printed.
void reserve_standard_streams();

// Writes out what was printed. Throws EnvironmentError with the system's words where not all of it, since the start of
// the program, could be written: a program must not report success when its result is lost.
void flush_standard_output();

}  // namespace noiseloom
