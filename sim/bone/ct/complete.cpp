#include "sim/bone/ct/complete.h"

#include <nifti1_io.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

namespace reamsim::ct {

bool nifti_is_complete(const std::string& path) {
  const std::unique_ptr<nifti_image, decltype(&nifti_image_free)> header(nifti_image_read(path.c_str(), 0),
                                                                         &nifti_image_free);
  if (!header || header->iname == nullptr || header->nbyper <= 0 || header->iname_offset < 0) return false;
  const double claimed = static_cast<double>(header->iname_offset) + static_cast<double>(header->nvox) * header->nbyper;
  // gzread() passes files that are not packed through as they are.
  const std::unique_ptr<gzFile_s, decltype(&gzclose)> file(gzopen(header->iname, "rb"), &gzclose);
  if (!file) return false;
  std::vector<char> chunk(1 << 20);
  double held = 0;
  while (held < claimed) {
    const int got = gzread(file.get(), chunk.data(), static_cast<unsigned>(chunk.size()));
    if (got <= 0) return false;
    held += got;
  }
  return true;
}

bool says_incomplete(const std::string& library_output) {
  constexpr std::array<const char*, 3> kComplaints{"data not read completely", "Uncompress failed",
                                                   "Incomplete Pixel Data"};
  return std::any_of(kComplaints.begin(), kComplaints.end(),
                     [&](const char* complaint) { return library_output.find(complaint) != std::string::npos; });
}

}  // namespace reamsim::ct
