#include "noiseloom/files/image_decoder.h"

#include <utility>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

ImageDecoder& current() {
  static ImageDecoder decoder;
  return decoder;
}

}  // namespace

void set_image_decoder(ImageDecoder decoder) { current() = std::move(decoder); }

InputArrayPtr decode_image(const std::string& path) {
  if (!current()) throw UserError(path, "this program reads no images; a .npy will do");
  return current()(path);
}

}  // namespace noiseloom
