// Images for the MPI program, which links no image library: noiseloom-study reads them and hands over the numbers.
#pragma once

#include <string>
#include <vector>

namespace noiseloom {

// Where noiseloom-study is: beside this program, else "" (whoever runs it then looks along the PATH).
std::string study_beside();

// From here on decode_image() (files/image_decoder.h) asks noiseloom-study.
void let_study_decode_images();

// Reads the image that a config names, if it names one, and keeps it for decode_image(): before MPI is started, as not
// every MPI library bears that another program is started afterwards. Only in the process that will be rank 0, as far
// as its environment tells. What goes wrong here is found again, and said, when the run asks for the image.
void decode_images_early(const std::string& config, const std::vector<std::string>& overrides);

}  // namespace noiseloom
