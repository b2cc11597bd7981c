// The grammar of ScalarApp, which makes spatiotemporal blue noise of scalars.
#include <fmt/format.h>

#include <array>

#include "noiseloom/core/text.h"
#include "published/programs.h"
#include "published/stbn_line.h"

namespace noiseloom {
namespace {

struct ScalarLine {
  std::string folder = "output";
  std::array<std::int64_t, 4> size = {128, 128, 64, 1};
  std::array<double, 4> sigma = {1.9, 1.9, 1.9, 1.9};
  double density = 0.1;
  std::string implementation = "sc211";
};

const std::vector<std::string> scalar_options = {
    "-o",   "--output", "--dimsX", "--dimsY", "--dimsZ", "--dimsW",         "--sX",
    "--sY", "--sZ",     "--sW",    "--ibpd",  "-i",      "--implementation"};

bool read_scalar_option(const std::string& name, WordReader& reader, ScalarLine& line) {
  constexpr std::string_view axes = "XYZW";
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    if (name == fmt::format("--dims{}", axes[axis])) return read_size(reader, name, line.size[axis]), true;
    if (name == fmt::format("--s{}", axes[axis])) return read_sigma(reader, name, line.sigma[axis]), true;
  }
  if (name == "--output") return read_folder(reader, line.folder), true;
  if (name == "--ibpd") {
    reader.skip();
    line.density = reader.number(name, {0, 0.5}).value_or(line.density);
    return true;
  }
  if (name != "--implementation") return false;
  reader.skip();
  line.implementation = reader.word(name, {"sc211", "sc22", "r211", "r22"});
  return true;
}

// Axes of one group share a sigma: x and y always, z and w in 2D x 2D.
void check_sigmas(WordReader& reader, const ScalarLine& line, bool pairs) {
  if (line.sigma[0] != line.sigma[1])
    reader.fault_of_line(
        fmt::format("--sX {} and --sY {}: must be the same, as x and y have one kernel", line.sigma[0], line.sigma[1]));
  if (pairs && line.size[2] > 1 && line.size[3] > 1 && line.sigma[2] != line.sigma[3])
    reader.fault_of_line(fmt::format("--sZ {} and --sW {}: must be the same, as z and w have one kernel in {}",
                                     line.sigma[2], line.sigma[3], line.implementation));
}

std::string mask_groups(const ScalarLine& line, bool pairs) {
  const auto group = [](const std::string& axes, double sigma) {
    return fmt::format("\n  {{ axes = \"{}\", kernel = \"gauss-energy\", sigma = {} }},", axes, number_text(sigma));
  };
  const bool has_z = line.size[2] > 1;
  const bool has_w = line.size[3] > 1;
  std::string text = group("xy", line.sigma[0]);
  if (pairs && has_z && has_w) return text + group("zw", line.sigma[2]);
  if (has_z) text += group("z", line.sigma[2]);
  if (has_w) text += group("w", line.sigma[3]);
  return text;
}

std::string mask_config(const ScalarLine& line, bool pairs) {
  std::string size = fmt::format("x = {}, y = {}", line.size[0], line.size[1]);
  if (line.size[2] > 1) size += fmt::format(", z = {}", line.size[2]);
  if (line.size[3] > 1) size += fmt::format(", w = {}", line.size[3]);
  return fmt::format(
      "[texture]\nsize    = {{ {} }}\nsamples = \"uniform\"\nseed    = {}\n\n[filter]\ncombine = \"sum\"\n"
      "groups  = [{}\n]\n\n[optimizer]\nmethod  = \"void-and-cluster\"\ndensity = {}\n",
      size, published_seed, mask_groups(line, pairs), number_text(line.density));
}

}  // namespace

PublishedLine read_stbn_scalar(const std::vector<std::string>& words) {
  PublishedLine result;
  result.extras.help = asks_for_help(words);
  if (result.extras.help) return result;
  ScalarLine line;
  OptionLine options(words);
  options.read({{"-o", "--output"}, {"-i", "--implementation"}}, scalar_options, result.extras,
               [&](const std::string& name, WordReader& reader) { return read_scalar_option(name, reader, line); });
  const bool pairs = line.implementation.ends_with("22");
  check_sigmas(options.reader(), line, pairs);
  options.reader().throw_faults();
  name_images(
      result, line.folder,
      fmt::format("stbn_scalar_{}_{}_{}x{}x{}", line.implementation.starts_with("sc") ? "Splice_Cache" : "Reference",
                  pairs ? "2Dx2D" : "2Dx1Dx1D", line.size[0], line.size[1], line.size[2]));
  result.images.channels = "R";
  result.config = mask_config(line, pairs);
  result.slices = line.size[2] * line.size[3];
  return result;
}

std::string stbn_scalar_help() {
  return "Command lines of ScalarApp, the published maker of scalar spatiotemporal blue noise, as they are.\n"
         "Usage: noiseloom stbn-scalar [OPTIONS]\n\n"
         "Options:\n"
         "  -o,--output DIR    folder to write to (output)\n"
         "  --dimsX N          width (128)\n"
         "  --dimsY N          height (128)\n"
         "  --dimsZ N          slices along z (64)\n"
         "  --dimsW N          slices along w (1)\n"
         "  --sX SIGMA         of the energy along x (1.9), the same as\n"
         "  --sY SIGMA         along y\n"
         "  --sZ SIGMA         along z (1.9)\n"
         "  --sW SIGMA         along w (1.9)\n"
         "  --ibpd SHARE       density of the initial binary pattern (0.1)\n"
         "  -i,--implementation WORD  sc211, r211: xy, z and w each; sc22, r22: xy and zw (sc211)\n" +
         extras_help() +
         "\nWrites DIR/stbn_scalar_Splice_Cache_2Dx1Dx1D_128x128x64_0.png and so on (r211, r22: Reference; sc22, r22: "
         "2Dx2D),\n"
         "8-bit grey; the number is z + Z w. The seed is the one that is built into the published program.\n\n"
         "  noiseloom stbn-scalar --dimsZ 32 -o stbn\n";
}

}  // namespace noiseloom
