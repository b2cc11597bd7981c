// Programs that textures are exported for, by name (--for): a table of what each reads.
//
// A consumer decides container, layout, number type, channels and names; a texture that it cannot take is refused with
// the nearest that it can. To add one, add a row in src/image/containers/consumers.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "noiseloom/core/error.h"
#include "noiseloom/image/export.h"

namespace noiseloom {

struct Consumer {
  std::string name;    // as --for takes it
  std::string reader;  // who that is, and how it reads the files
  std::string format;  // a container
  std::string layout;
  std::vector<std::string> depths;  // the first is the default
  // The channels of a pixel for samples of 1, 2, 3 and 4 channels: as --channels takes them, "as-is" for what the
  // container makes of them, "" where samples of so many are not taken.
  std::array<std::string, 4> channels;
  std::string
      naming;  // nvidia, ea, plain, or the name of the one file: $TYPE, $Type, $SIZE, $STEM stand for the texture's
  // What sizes must be, 0 or false where they may be any.
  std::array<std::int64_t, 3> size = {};  // x, y, slices
  bool square = false;                    // slices as wide as high
  bool powers_of_two = false;             // x and y
  bool slices_power_of_two = false;
  std::int64_t most_rows = 0;  // of a strip
};

const std::vector<Consumer>& consumers();
// A line each: name, files, sizes.
std::string consumers_table();

// The options with what the consumer decides in them. Appends what it cannot take to `faults`. Requires a consumer in
// the options. `has_order`: the texture is a mask with the sequence of its pixels.
ExportOptions for_consumer(ExportOptions options, const ProblemSpec& problem, int channels, const std::string& stem,
                           bool has_order, std::vector<Fault>& faults);

}  // namespace noiseloom
