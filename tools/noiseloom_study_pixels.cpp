// pixels: the numbers of an image for noiseloom, which links no image library (noiseloom_pixels.h). No command for
// people.
#include <cstdio>
#include <memory>
#include <string>

#include "noiseloom/core/error.h"
#include "noiseloom/image/colour.h"
#include "noiseloom_pixels.h"
#include "noiseloom_study.h"

namespace noiseloom {
namespace {

void write(const PixelsHeader& header, const void* bytes, std::size_t size) {
  const bool whole = std::fwrite(&header, sizeof header, 1, stdout) == 1 && std::fwrite(bytes, 1, size, stdout) == size;
  if (!whole) throw EnvironmentError("the pixels cannot be handed to noiseloom");
}

void write_words(PixelsHeader::What what, const std::string& words) {
  write({.what = what, .sizes = {words.size(), 0, 0}}, words.data(), words.size());
}

void write_pixels(const std::string& path) {
  InputArrayPtr pixels;
  try {
    pixels = read_colour(path);
  } catch (const UserError& error) {
    return write_words(PixelsHeader::What::user_error, error.faults().front().text);
  } catch (const EnvironmentError& error) {
    return write_words(PixelsHeader::What::environment_error, error.what());
  }
  PixelsHeader header;
  for (std::size_t axis = 0; axis < 3; ++axis) header.sizes[axis] = static_cast<std::uint64_t>(pixels->shape[axis]);
  const auto& values = std::get<SharedValues<float>>(pixels->values);
  write(header, values.data(), values.size() * sizeof(float));
}

}  // namespace

void add_pixels(CLI::App& app) {
  CLI::App* const command = app.add_subcommand("pixels", "the numbers of an image, for noiseloom");
  command->group("");  // not in the help
  const auto path = std::make_shared<std::string>();
  command->add_option("IMAGE", *path)->required();
  command->callback([path] { write_pixels(*path); });
}

}  // namespace noiseloom
