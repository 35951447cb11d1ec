// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <new>

#include "sim/api/reamsim/simulation.h"
#include "sim/base/error.h"

namespace reamsim {

/// Calls work(), and turns its exceptions into those of the library.
template <class Work>
auto guarded(const Work& work) {
  try {
    return work();
  } catch (const Error&) {
    throw;
  } catch (const InputError& error) {
    throw BadInput(error.what());
  } catch (const std::bad_alloc&) {
    throw RunFailure("not enough memory");
  } catch (const std::exception& error) {
    throw RunFailure(error.what());
  }
}

}  // namespace reamsim
