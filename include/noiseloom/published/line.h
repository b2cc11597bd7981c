// Command lines of the published programs, taken for what they mean here: a config, and images under the names that
// those programs give them.
//
//   fastnoise    the program of [FAST24]: FastNoise.exe SPACE DIST XY Z COMBINE W H D FILE [OPTION...]
//   stbn-scalar  ScalarApp of the spatiotemporal blue noise SDK [STBN22]
//   stbn-vector  VectorApp of the same
//
// A word that the grammar does not have is a fault, with its place; nothing is skipped. Where a line means something
// that is done differently here, a note says so.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "noiseloom/image/export.h"

namespace noiseloom {

// An array that the config names, and that is made from what the line names, once its size was checked.
struct PublishedInput {
  std::string path;                 // .npy
  std::vector<std::int64_t> shape;  // last dimension fastest
  std::function<std::vector<float>()> values;
};

// Options that the published programs do not have.
struct PublishedExtras {
  bool help = false;
  bool print_config = false;
  bool overwrite = false;
  bool quiet = false;
  bool json = false;
  std::string progress = "auto";  // as of generate
  int threads = 0;                // 0: all processors
};

struct PublishedLine {
  std::string config;              // TOML, with comments
  std::vector<std::string> notes;  // what is done differently here
  std::vector<PublishedInput> inputs;
  ExportOptions images;  // format csv: write_csv() instead of an export
  std::string stem;      // of the run file, while images are made: beside them
  bool seed_is_drawn = false;
  std::int64_t seed = 0;
  std::int64_t slices = 1;
  // Pictures on the way: the textures that so many iterations make, ascending; file names get ".STEP" before their
  // ending.
  std::vector<std::int64_t> steps;
  PublishedExtras extras;
};

struct PublishedProgram {
  std::string name;      // as the command is called
  std::string sentence;  // for help
  std::string help;      // all of --help
  // Throws UserError with every fault. After --help nothing but extras.help is filled.
  PublishedLine (*read)(const std::vector<std::string>& words);
};

const std::vector<PublishedProgram>& published_programs();
// nullptr where none has that name.
const PublishedProgram* find_published_program(const std::string& name);

// The files that the line makes, `step` 0 for the last ones: what must not be there yet.
std::vector<std::string> published_files(const PublishedLine& line, std::int64_t step);
// The same as the line, for the pictures of a step.
ExportOptions images_of_step(const PublishedLine& line, std::int64_t step);

// What fastnoise calls csv: the numbers of every channel in quotes, RGBA, a line a row of the image. One file, or one a
// slice where `files` has as many. Throws as export_run_file() does.
void write_csv(const std::string& run_file, const std::vector<std::string>& files, bool overwrite, FileOps& ops);

}  // namespace noiseloom
