// One run as the loop drives it, whatever its method: steps between safe points, saving and going on, and what it says.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/dist/communicator.h"
#include "noiseloom/files/run_file.h"
#include "noiseloom/run/progress.h"

namespace noiseloom {

// What a save needs beside the run itself.
struct SaveTarget {
  std::string path;
  std::map<std::string, Attribute> provenance;
};

// What prepare() and start() throw on all ranks where a signal asked for a stop before there was anything to save.
struct StartStopped {};

class Job {
 public:
  virtual ~Job() = default;

  // Takes up memory; everything else comes after it. The arguments outlive the job. May throw StartStopped.
  // *Collective*
  virtual void prepare(const Communicator& communicator, ThreadPool& pool) = 0;
  virtual void start(double run_s) = 0;                  // may throw StartStopped. *Collective*
  virtual void restore(const RunFileReader* saved) = 0;  // rank 0 has the file, the others nullptr. *Collective*
  // Goes on to the next safe point, half a second away at most where the method can. Rank 0's clock. *Collective*
  virtual void step(double run_s) = 0;
  virtual bool finished() const = 0;
  // Publishes the present state; the checksum of /samples, on rank 0. Throws SharedEnvironmentError. *Collective*
  virtual std::string save(const SaveTarget& target) = 0;

  // Brings up to date what the next save will say of the run (R), where it is stopped before its end. *Collective*
  virtual void refresh() {}
  virtual bool refreshes_quickly() const { return true; }  // in moments, as far as is known. *Collective*
  virtual std::vector<SliceDataset> datasets() const = 0;  // of the run file

  virtual std::string title() const = 0;        // "7x5x3 of uniform, anneal"
  virtual std::string start_words() const = 0;  // what start() does, as it may take a while
  virtual bool is_coupled() const = 0;          // do slices depend on each other?
  virtual std::string position() const = 0;     // "iteration 40, R 0.12345"
  virtual std::size_t num_rows() const = 0;     // of the history
  virtual ProgressFigures figures(double run_s, double part_s) = 0;
  virtual std::int64_t bytes_sent() const { return 0; }  // by this rank to others, in this part
  // Lines of the closing summary, label and text. *Collective*
  virtual std::vector<std::pair<std::string, std::string>> summary(double run_s) = 0;
};

// By the config's method. Throws UserError for what the config names and cannot be used. `config` outlives it.
std::unique_ptr<Job> make_job(const RunConfig& config);
std::unique_ptr<Job> make_swap_job(const RunConfig& config);
std::unique_ptr<Job> make_order_job(const RunConfig& config);
std::unique_ptr<Job> make_construct_job(const RunConfig& config);

}  // namespace noiseloom
