#include "run/checkpoint_parts.h"

#include <memory>

namespace noiseloom {

std::string publish_run(FileOps& ops, const std::string& path, const RunFileContent& content,
                        const Partition& partition, const Communicator& communicator,
                        const std::function<void(SliceIndex, std::vector<std::byte>&)>& produce) {
  std::unique_ptr<RunFileWriter> writer;
  communicator.on_root([&] { writer = std::make_unique<RunFileWriter>(ops, path, content); });
  const auto consume = [&](SliceIndex slice, std::span<const std::byte> block) {
    for (std::size_t k = 0; k < content.datasets.size(); ++k) {
      const std::size_t size = bytes_per_slice(content.datasets[k], content.extents);
      writer->write_slice(static_cast<int>(k), slice, block.first(size));
      block = block.subspan(size);
    }
  };
  communicator.stream_to_root(partition, produce, consume);
  std::string checksum;
  communicator.on_root([&] {
    checksum = writer->checksum(0);
    writer->publish();
  });
  return checksum;
}

}  // namespace noiseloom
