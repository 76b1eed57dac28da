// SPDX-License-Identifier: MIT
#pragma once

namespace maxlogdet {

/// The instruction set that a Selector made now would run on: "sse2", "avx2", "avx512" or "neon"; the widest one that
/// is both built in and supported by this machine, unless the environment variable MAXLOGDET_ISA names another (empty
/// is as good as unset, upper case is another name).
/// "none" if that names one which is not built in or not supported: select() then answers Status::unsupported_isa.
const char* active_isa() noexcept;

/// Name of the i-th instruction set built into this library, narrowest first; nullptr when there are fewer.
const char* built_in_isa(int i) noexcept;

/// Whether this machine can run the instruction set of that name; false for an unknown name or nullptr.
bool isa_is_supported(const char* name) noexcept;

}  // namespace maxlogdet
