#include "noiseloom/run/shared_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <span>
#include <sstream>
#include <string>

#include "noiseloom/config/inputs.h"
#include "noiseloom/dist/node_memory.h"
#include "noiseloom/samples/luminance.h"

namespace noiseloom {
namespace {

// Little enough for an MPI count and for the memory of a rank, large enough that the number of messages is no matter.
constexpr std::size_t piece_values = std::size_t{1} << 21;

// The values that rank 0 has (`own`; nullptr elsewhere), once a node.
template <class T>
SharedValues<T> broadcast_values(const SharedValues<T>* own, const Communicator& communicator) {
  std::string piece = own != nullptr ? std::to_string(own->size()) : "";
  communicator.broadcast(piece);
  const std::size_t count = std::stoull(piece);
  NodeMemory memory(communicator, count * sizeof(T));
  const std::span<std::byte> received = memory.to_fill();
  for (std::size_t at = 0; at < count; at += piece_values) {
    const std::size_t bytes = std::min(piece_values, count - at) * sizeof(T);
    if (own != nullptr) piece.assign(reinterpret_cast<const char*>(own->data() + at), bytes);
    communicator.broadcast(piece);
    if (!received.empty()) std::memcpy(received.data() + at * sizeof(T), piece.data(), bytes);
  }
  return memory.filled<T>();
}

InputArrayPtr broadcast_array(const InputArrayPtr& own, const Communicator& communicator) {
  std::string head;  // the type and the shape
  if (own) {
    head = std::holds_alternative<SharedValues<double>>(own->values) ? "double" : "float";
    for (const std::int64_t size : own->shape) head += fmt::format(" {}", size);
  }
  communicator.broadcast(head);
  InputArray received;
  std::istringstream words(head);
  std::string type;
  words >> type;
  for (std::int64_t size = 0; words >> size;) received.shape.push_back(size);
  const auto values = [&]<class T>(T) {
    return broadcast_values(own ? &std::get<SharedValues<T>>(own->values) : nullptr, communicator);
  };
  if (type == "float") {
    received.values = values(float{});
  } else {
    received.values = values(double{});
  }
  return std::make_shared<const InputArray>(std::move(received));
}

void share_masses(SampleSpec& samples, const Communicator& communicator) {
  const std::size_t count = num_image_masses(*samples.array);
  NodeMemory memory(communicator, count * sizeof(std::uint64_t));
  const std::span<std::byte> bytes = memory.to_fill();
  communicator.together([&] {
    if (bytes.empty()) return;
    make_image_masses(samples, {reinterpret_cast<std::uint64_t*>(bytes.data()), count});
  });
  samples.masses = memory.filled<std::uint64_t>();
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
  if (config.problem.samples.is_image()) share_masses(config.problem.samples, communicator);
}

}  // namespace noiseloom
