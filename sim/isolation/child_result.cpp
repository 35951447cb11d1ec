#include "sim/isolation/child_result.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <new>

#include "sim/base/error.h"

namespace reamsim {

namespace {

constexpr std::size_t kHeadBytes = 16384;
constexpr std::uint64_t kLeastResult = std::uint64_t{1} << 20;

std::uint64_t aligned(std::uint64_t place, std::uint64_t alignment) {
  return (place + alignment - 1) / alignment * alignment;
}

}  // namespace

SharedMemory::SharedMemory(std::uint64_t result_bytes) : capacity_(std::max(result_bytes, kLeastResult)) {
  static_assert(sizeof(Head) <= kHeadBytes && kHeadBytes % ResultWriter::kAlignment == 0);
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free);  // between processes
  // Anonymous: the limit of file sizes, which this process may have itself, counts for files in memory too.
  for (; memory_ == nullptr; capacity_ /= 2) {
    if (capacity_ < kLeastResult) throw RunError("no memory to read files in a child process");
    void* memory = mmap(nullptr, kHeadBytes + capacity_, PROT_READ | PROT_WRITE,
                        MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (memory == MAP_FAILED) continue;
    memory_ = new (memory) Head;
    break;
  }
}

SharedMemory::~SharedMemory() {
  munmap(memory_, kHeadBytes + capacity_);
}

std::byte* SharedMemory::result() const {
  return static_cast<std::byte*>(memory_) + kHeadBytes;
}

void ResultWriter::put(const std::string& text) {
  put(std::uint64_t{text.size()});
  std::memcpy(take(text.size(), 1), text.data(), text.size());
}

void ResultWriter::begin_file(const std::string& path) {
  SharedMemory::Head& head = memory_.head();
  const std::size_t length = std::min(path.size(), SharedMemory::Head::kPathBytes - 1);
  std::memcpy(head.path, path.data(), length);
  head.path[length] = '\0';
  ++head.files_read;
}

std::byte* ResultWriter::take(std::uint64_t bytes, std::size_t alignment) {
  std::atomic<std::uint64_t>& end = memory_.head().bytes;
  const std::uint64_t place = aligned(end, alignment);
  if (place > memory_.capacity() || bytes > memory_.capacity() - place) throw ResultTooLarge();
  end = place + bytes;
  return memory_.result() + place;
}

ResultReader::ResultReader(const SharedMemory& memory, std::string path, std::string key)
    : result_(memory.result()),
      bytes_(std::min(memory.head().bytes.load(), memory.capacity())),
      path_(std::move(path)),
      key_(std::move(key)) {}

std::string ResultReader::text() {
  const auto length = get<std::uint64_t>();
  const std::byte* first = take(length, 1);
  return {reinterpret_cast<const char*>(first), length};
}

const std::byte* ResultReader::take(std::uint64_t bytes, std::size_t alignment) {
  const std::uint64_t place = aligned(place_, alignment);
  if (place > bytes_ || bytes > bytes_ - place) fail();
  place_ = place + bytes;
  return result_ + place;
}

void ResultReader::give_back(const std::byte* first, std::uint64_t bytes) {
  const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  const std::uintptr_t from = aligned(reinterpret_cast<std::uintptr_t>(first), page);
  const std::uintptr_t to = (reinterpret_cast<std::uintptr_t>(first) + bytes) / page * page;
  if (to > from) madvise(reinterpret_cast<void*>(from), to - from, MADV_REMOVE);
}

void ResultReader::fail() const {
  throw InputError({path_, 0, 0}, key_, "the process that reads it handed back an inconsistent result",
                   "the file is damaged: give a complete file");
}

}  // namespace reamsim
