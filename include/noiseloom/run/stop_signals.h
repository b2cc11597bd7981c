// Signals that ask a run to save what it has and stop: the batch system's warnings (USR1, USR2, XCPU), TERM, Ctrl-C
// (INT), a terminal that was closed (HUP), a reader that went away (PIPE). A handler only notes the number; the run
// looks at it between two steps.
#pragma once

#include <string>

namespace noiseloom {

// From here on these signals are noted and no longer end the process; one that was set to be ignored by whoever
// started the process (nohup, a shell's background job) stays so where that is the custom: HUP and INT. Call it first
// thing in main, and again after MPI_Init, since a library may have put handlers of its own in place. Also makes a
// write past a file size limit an error of that write (XFSZ).
void note_stop_signals();

// The signal that arrived last, 0 if none did.
int noted_stop_signal();

// For a process that goes on after a stop, such as a test.
void forget_stop_signal();

// "SIGUSR1", or "signal 34".
std::string signal_name(int number);

}  // namespace noiseloom
