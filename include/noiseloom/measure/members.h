// Whether textures that were made with different seeds are independent of each other, and alike in distribution.
//
// Correlation: over the whole torus of two members a and b, for every shift d of one against the other,
//
//   r_ab(d) = sum_k A(k) conj(B(k)) exp(2 pi i k d) / sqrt(sum |A|^2 sum |B|^2)        k other than 0, summed over
//   channels
//
// A shift finds what was made from one stream of random numbers read at another place. Of independent members the
// phases are, so r has the mean 0 and the variance sum_k |sum A conj(B)|^2 / (sum |A|^2 sum |B|^2), the inner sum over
// channels, whose phases need not be independent of each other. It is 1 / N for white noise of one channel and more for
// blue noise; as a sum of many r is normal. The same over the frequencies of a band, without a
// shift, is the band's cross spectrum. `odds` is how likely independent members would have a value as large anywhere
// among all that were looked at: at most the sum of their tails.
//
// Members of one seed and other settings begin with the same random numbers, and are correlated as they should be:
// such pairs are left out, as are those of different sizes or numbers of channels, which have no common frequencies.
//
// Distribution: Kolmogorov's distance of a member's values from those of all members with the same settings, against
// the bound of Dvoretzky, Kiefer and Wolfowitz (measure/distribution.h), and the logarithm of its power in each band
// against that of the others (Student's t), where there are four or more.
//
// A fault is what chance makes with odds below one in a million.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "noiseloom/core/parallel.h"
#include "noiseloom/measure/verify.h"

namespace noiseloom {

struct MemberFile {
  std::string name;
  std::string path;      // a run file
  std::string checksum;  // of /samples
  std::string settings;  // but for the seed: members of other settings differ in distribution, and perhaps in size
  std::string seed;      // "": the one in the file's config, if any
};

struct LargestCorrelation {
  double value = 0;       // r
  double deviations = 0;  // |r| over its standard deviation
  double odds = 1;
  std::string where;  // "seed1 and seed2", with the shift or the band
};

struct MembersVerification {
  std::size_t members = 0;
  std::size_t read = 0;      // all, or as many evenly spread ones of each size as take bounded time
  std::size_t compared = 0;  // of these, with one other at least
  std::int64_t pairs = 0;    // that were compared; the others of those that were read:
  std::int64_t pairs_of_one_seed = 0;
  std::int64_t pairs_of_other_sizes = 0;
  std::size_t alike = 0;  // how many had their values held against those of others with the same settings
  LargestCorrelation unshifted;
  LargestCorrelation shifted;  // of the pairs that are most correlated at another shift than 0
  struct Band {
    double first = 0;  // cycles a pixel over x and y
    double last = 0;
    double power = 0;  // mean over members; white noise: 1
    LargestCorrelation largest;
  };
  std::vector<Band> bands;  // none where no pair was compared
  double distance = 0;      // the largest over its bound: at most 1 where the distributions are alike
  std::vector<Finding> findings;

  // That nothing was found wrong with what was compared, which may be nothing.
  bool is_sound() const { return findings.empty(); }
};

// Throws UserError where there are fewer than two members, and as load_stored_texture does.
MembersVerification verify_members(const std::vector<MemberFile>& members, ThreadPool& pool);

std::string members_text(const MembersVerification& found, const std::string& name);
std::string members_json(const MembersVerification& found, const std::string& name);

}  // namespace noiseloom
