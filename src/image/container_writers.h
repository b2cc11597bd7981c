// The functions that make the writers of the table in containers.cpp.
#pragma once

#include <memory>

#include "noiseloom/image/container.h"

namespace noiseloom {

std::unique_ptr<ContainerWriter> make_png_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_exr_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_tiff_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_hdr_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_npy_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_raw_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_csv_points_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_npy_points_writer(OutputFiles& files);

}  // namespace noiseloom
