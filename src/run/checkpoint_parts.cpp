#include "run/checkpoint_parts.h"

#include <memory>

namespace noiseloom {

std::string publish_run(FileOps& ops, const std::string& path, const RunFileContent& content,
                        const Partition& partition, const Communicator& communicator, const ProduceSlice& produce) {
  std::unique_ptr<RunFileWriter> writer;
  communicator.on_root([&] { writer = std::make_unique<RunFileWriter>(ops, path, content); });
  for (std::size_t dataset = 0; dataset < content.datasets.size(); ++dataset) {
    communicator.stream_to_root(
        partition, [&](SliceIndex slice, std::vector<std::byte>& block) { produce(dataset, slice, block); },
        [&](SliceIndex slice, std::span<const std::byte> block) {
          writer->write_slice(static_cast<int>(dataset), slice, block);
        });
  }
  std::string checksum;
  communicator.on_root([&] {
    checksum = writer->checksum(0);
    writer->publish();
  });
  return checksum;
}

}  // namespace noiseloom
