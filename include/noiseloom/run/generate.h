// One texture from its config to its run file, on any number of ranks and threads, stopped and resumed at will. What
// the command `generate` does once its options are read; options, exit status and printing stay with the program.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "noiseloom/dist/communicator.h"
#include "noiseloom/dist/watchdog.h"
#include "noiseloom/run/loop.h"
#include "noiseloom/run/progress.h"

namespace noiseloom {

struct GenerateRequest {
  std::string config;                  // file name
  std::vector<std::string> overrides;  // "texture.seed=2"
  std::string output;                  // run file; *.h5 or *.hdf5
  bool resume = false;                 // go on from the output if it is there
  bool overwrite = false;              // replace the output if it is there; not with resume
  int threads = 0;                     // of each rank; 0: the node's processors shared by its ranks
  // One of several that share the work: no fault where another holds the output (GenerateResult::held), and no warning
  // where the launcher started more ranks than these.
  bool skip_if_held = false;
  LoopSettings loop;
  WatchSettings watch;
};

struct GenerateResult {
  bool held = false;       // by another run: nothing was done
  bool finished = false;   // else stopped early: run again with resume
  std::string conclusion;  // where it is not finished: why, how far it got, what is saved. On rank 0
  std::vector<std::pair<std::string, std::string>> summary;  // where it is finished: label and text. On rank 0
};

// `progress` is silent on all ranks but 0. Throws SharedUserError, SharedEnvironmentError and OutputLost (another
// run has taken the output) on every rank; anything else that is thrown is the trouble of one rank alone, and the
// caller must abort all. Where a rank is lost, the process ends with exit_lost_rank (dist/watchdog.h). *Collective*
GenerateResult generate(const GenerateRequest& request, const Communicator& communicator, Progress& progress);

}  // namespace noiseloom
