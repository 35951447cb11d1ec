// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/isolation/child_result.h"

#include <sys/ipc.h>
#include <sys/mman.h>
#include <sys/shm.h>
#include <unistd.h>
#include <new>

#include "sim/base/process.h"

namespace reamsim {

namespace {

constexpr std::uint64_t kLeastResult = std::uint64_t{1} << 20;
void* const kNotAttached = reinterpret_cast<void*>(-1);

std::uint64_t aligned(std::uint64_t place, std::uint64_t alignment) {
  return (place + alignment - 1) / alignment * alignment;
}

}  // namespace

SharedMemory::SharedMemory(std::uint64_t result_bytes) : capacity_(std::max(result_bytes, kLeastResult)) {
  static_assert(sizeof(Head) <= kHeadBytes && kHeadBytes % ResultWriter::kAlignment == 0);
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free);  // between processes
  // System V memory: for files in memory the limit of file sizes counts, which this process may have itself.
  for (; memory_ == nullptr; capacity_ /= 2) {
    if (capacity_ < kLeastResult) {
      throw RunError("no memory to read files in a child process" + address_space_note("; ", ": raise it"));
    }
    id_ = shmget(IPC_PRIVATE, kHeadBytes + capacity_, IPC_CREAT | SHM_NORESERVE | 0600);
    if (id_ < 0) continue;
    void* memory = shmat(id_, nullptr, 0);
    shmctl(id_, IPC_RMID, nullptr);  // it exists as long as a process holds it
    if (memory == kNotAttached) continue;
    memory_ = new (memory) Head;
    break;
  }
}

SharedMemory::SharedMemory(const Handle& handle) : id_(handle.id), capacity_(handle.capacity) {
  void* memory = shmat(id_, nullptr, 0);
  if (memory == kNotAttached) throw RunError("the shared memory of the parent process no longer exists");
  memory_ = memory;
}

SharedMemory::~SharedMemory() {
  shmdt(memory_);
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

ResultReader::ResultReader(std::shared_ptr<const SharedMemory> memory, ForeignFile file)
    : memory_(std::move(memory)),
      result_(memory_->result()),
      bytes_(std::min(memory_->head().bytes.load(), memory_->capacity())),
      file_(std::move(file)) {}

const void* ResultReader::next(std::uint64_t bytes, std::uint64_t alignment) {
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
  throw file_.error("the process that reads it handed back an inconsistent result",
                    "the file is damaged: give a complete file");
}

}  // namespace reamsim
