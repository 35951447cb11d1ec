#include "sim/bone/ct/dicom_probe.h"

#include <itkGDCMImageIO.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <memory>
#include <new>

#include "sim/base/error.h"
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

/// Reads the files from `first` on and exits.
template <typename Read>
[[noreturn]] void read_all_and_exit(const std::vector<std::string>& files, std::size_t first, Counter& current,
                                    const Read& read) {
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  for (const int signal : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL}) std::signal(signal, SIG_DFL);
  for (std::size_t n = first; n < files.size(); ++n) {
    current.store(n);
    try {
      read(files[n]);
    } catch (...) {
      continue;  // the reader will report it
    }
  }
  _exit(0);
}

/// The first file from `first` on that crashes a child process; files.size() if none does.
template <typename Read>
std::size_t first_that_crashes(const std::vector<std::string>& files, std::size_t first, const Read& read) {
  const auto current = shared_counter();
  if (first >= files.size() || !current) return files.size();
  const QuietLibraries quiet;
  const pid_t child = fork();
  if (child == 0) read_all_and_exit(files, first, *current, read);
  if (child < 0) return files.size();
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return files.size();
  }
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
