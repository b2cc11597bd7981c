// The files that a config names, on all ranks: read by one of them.
#pragma once

#include "noiseloom/config/config.h"
#include "noiseloom/dist/communicator.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {

// Gives every rank's config the contents of the files that it names, as rank 0 has them: from the run file that it goes
// on from (`saved`; nullptr where there is none and on the other ranks), and what that does not hold from the files
// themselves. So all ranks work from the same numbers, whatever lies under that name on their nodes. Throws UserError
// on every rank if a file cannot be used. *Collective*
void share_inputs(RunConfig& config, const RunFileReader* saved, const Communicator& communicator);

}  // namespace noiseloom
