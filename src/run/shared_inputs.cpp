#include "noiseloom/run/shared_inputs.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "noiseloom/config/inputs.h"

namespace noiseloom {
namespace {

// Little enough for an MPI count and for the memory of a rank, large enough that the number of messages is no matter.
constexpr std::size_t piece_values = std::size_t{1} << 21;

// The values that rank 0 has (`own`; nullptr elsewhere) as `received` on all others.
template <class T>
void broadcast_values(const std::vector<T>* own, std::vector<T>& received, const Communicator& communicator) {
  std::string piece = own != nullptr ? std::to_string(own->size()) : "";
  communicator.broadcast(piece);
  const std::size_t count = std::stoull(piece);
  communicator.together([&] {
    if (own == nullptr) received.resize(count);
  });
  for (std::size_t at = 0; at < count; at += piece_values) {
    const std::size_t bytes = std::min(piece_values, count - at) * sizeof(T);
    if (own != nullptr) piece.assign(reinterpret_cast<const char*>(own->data() + at), bytes);
    communicator.broadcast(piece);
    if (own == nullptr) std::memcpy(received.data() + at, piece.data(), bytes);
  }
}

InputArrayPtr broadcast_array(const InputArrayPtr& own, const Communicator& communicator) {
  using Floats = std::vector<float>;
  using Doubles = std::vector<double>;
  std::string type = own && std::holds_alternative<Doubles>(own->values) ? "double" : "float";
  communicator.broadcast(type);
  InputArray received;
  broadcast_values(own ? &own->shape : nullptr, received.shape, communicator);
  if (type == "float") {
    broadcast_values(own ? &std::get<Floats>(own->values) : nullptr, received.values.emplace<Floats>(), communicator);
  } else {
    broadcast_values(own ? &std::get<Doubles>(own->values) : nullptr, received.values.emplace<Doubles>(), communicator);
  }
  return own ? own : std::make_shared<const InputArray>(std::move(received));
}

}  // namespace

void share_inputs(RunConfig& config, const RunFileReader* saved, const Communicator& communicator) {
  communicator.on_root([&] {
    if (saved != nullptr) take_inputs(config, saved->content().inputs, saved->path());
    read_inputs(config);
  });
  if (communicator.size() == 1) return;
  for_each_input(config, [&](InputArrayPtr& array) {
    array = broadcast_array(communicator.is_root() ? array : nullptr, communicator);
  });
}

}  // namespace noiseloom
