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
std::unique_ptr<ContainerWriter> make_ktx2_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_dds_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_header_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_hlsl_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_glsl_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_wgsl_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_godot_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_mpv_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_remix_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_pbrt_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_imagemagick_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_ghostscript_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_gimp_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_csv_points_writer(OutputFiles& files);
std::unique_ptr<ContainerWriter> make_npy_points_writer(OutputFiles& files);

}  // namespace noiseloom
