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

/// A counter in memory that a child process shares with its parent.
class SharedCounter {
 public:
  SharedCounter() {
    void* memory = mmap(nullptr, sizeof(Count), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory != MAP_FAILED) count_ = new (memory) Count(0);
  }
  ~SharedCounter() {
    if (count_ != nullptr) munmap(count_, sizeof(Count));
  }
  SharedCounter(const SharedCounter&) = delete;
  SharedCounter& operator=(const SharedCounter&) = delete;

  [[nodiscard]] bool usable() const { return count_ != nullptr; }
  void set(std::size_t value) { count_->store(value); }
  [[nodiscard]] std::size_t get() const { return count_->load(); }

 private:
  using Count = std::atomic<std::size_t>;
  Count* count_ = nullptr;
};

void read_whole(const std::string& file, const std::string& key) {
  const auto io = itk::GDCMImageIO::New();
  if (!io->CanReadFile(file.c_str())) return;
  io->SetFileName(file);
  io->ReadImageInformation();
  const ScanGeometry geometry = geometry_of(*io, file, key, true);
  check_fits_in_memory(static_cast<double>(geometry.size()), io->GetComponentSize(), file, key);
  read_voxels(*io, {Vec3i::Zero(), geometry.dims}, file, key);
}

/// The first file from `first` on whose reading ends a child process; files.size() where none does.
template <typename Read>
std::size_t first_that_kills(const std::vector<std::string>& files, std::size_t first, const Read& read) {
  SharedCounter current;
  if (first >= files.size() || !current.usable()) return files.size();
  const QuietLibraries quiet;  // the child's last words, too
  const int status = run_in_child([&] {
    for (std::size_t n = first; n < files.size(); ++n) {
      current.set(n);
      try {
        read(files[n]);
      } catch (...) {
        continue;  // the reader proper meets it again, and says what it is
      }
    }
  });
  return WIFEXITED(status) ? files.size() : current.get();
}

}  // namespace

void check_dicom_is_survived(const std::vector<std::string>& files, const std::string& key) {
  const std::size_t killed = first_that_kills(files, 0, [&key](const std::string& file) { read_whole(file, key); });
  if (killed == files.size()) return;
  throw InputError({files[killed]}, key, "the DICOM file is damaged and cannot be read", "give a complete file");
}

std::vector<bool> dicom_headers_survived(const std::vector<std::string>& files) {
  const auto read = [](const std::string& file) {
    DicomHeader header;
    read_dicom_header(file, header);
  };
  std::vector<bool> out(files.size(), true);
  for (std::size_t n = first_that_kills(files, 0, read); n < files.size(); n = first_that_kills(files, n + 1, read)) {
    out[n] = false;
  }
  return out;
}

}  // namespace reamsim::ct
