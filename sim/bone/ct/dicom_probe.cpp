#include "sim/bone/ct/dicom_probe.h"

#include <itkGDCMImageIO.h>
#include <sys/mman.h>
#include <sys/wait.h>

#include <atomic>
#include <memory>
#include <new>

#include "sim/base/error.h"
#include "sim/base/process.h"
#include "sim/bone/ct/dicom_header.h"
#include "sim/bone/ct/image_file.h"
#include "sim/bone/ct/quiet.h"

namespace reamsim::ct {

namespace {

using Counter = std::atomic<std::size_t>;
struct Unmap {
  void operator()(Counter* counter) const { munmap(counter, sizeof(Counter)); }
};

/// A counter in memory that a child process shares with its parent; nullptr on failure.
std::unique_ptr<Counter, Unmap> shared_counter() {
  void* memory = mmap(nullptr, sizeof(Counter), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  return std::unique_ptr<Counter, Unmap>(memory == MAP_FAILED ? nullptr : new (memory) Counter(0));
}

void read_whole(const std::string& file, const std::string& key) {
  const auto io = itk::GDCMImageIO::New();
  if (!io->CanReadFile(file.c_str())) return;
  io->SetFileName(file);
  io->ReadImageInformation();
  const ScanGeometry geometry = geometry_of(*io, file, key, true);
  check_fits_in_memory(static_cast<double>(geometry.size()), io->GetComponentSize(), file, key);
  read_voxels(*io, {Vec3i::Zero(), geometry.dims}, file, key);
}

/// The first file from `first` on that crashes a child process; files.size() if none does.
template <typename Read>
std::size_t first_that_crashes(const std::vector<std::string>& files, std::size_t first, const Read& read) {
  const auto current = shared_counter();
  if (first >= files.size() || !current) return files.size();
  const QuietLibraries quiet;
  const int status = run_in_child([&] {
    for (std::size_t n = first; n < files.size(); ++n) {
      current->store(n);
      try {
        read(files[n]);
      } catch (...) {
        continue;  // the reader will report it
      }
    }
  });
  return WIFEXITED(status) ? files.size() : current->load();
}

}  // namespace

void check_dicom_in_child(const std::vector<std::string>& files, const std::string& key) {
  const std::size_t crashing = first_that_crashes(files, 0, [&key](const std::string& file) { read_whole(file, key); });
  if (crashing == files.size()) return;
  throw InputError({files[crashing]}, key, "the DICOM file is damaged and cannot be read", "give a complete file");
}

std::vector<bool> dicom_headers_readable(const std::vector<std::string>& files) {
  const auto read = [](const std::string& file) {
    DicomHeader header;
    read_dicom_header(file, header);
  };
  std::vector<bool> out(files.size(), true);
  for (std::size_t n = first_that_crashes(files, 0, read); n < files.size();
       n = first_that_crashes(files, n + 1, read)) {
    out[n] = false;
  }
  return out;
}

}  // namespace reamsim::ct
