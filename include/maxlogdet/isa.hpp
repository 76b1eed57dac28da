// SPDX-License-Identifier: MIT
#pragma once

namespace maxlogdet {

/// The instruction set of a Selector made now: "sse2", "avx2", "avx512" or "neon", the widest one that is built in and
/// supported by this machine, unless the environment variable MAXLOGDET_ISA names another. "none" if that is not
/// available: select() then answers Error::unsupported_isa.
const char* active_isa() noexcept;

/// Name of the i-th instruction set built in, narrowest first; nullptr when there are fewer.
const char* built_in_isa(int i) noexcept;

/// Returns whether this machine supports the instruction set of that name; false for an unknown name or nullptr.
bool isa_is_supported(const char* name) noexcept;

}  // namespace maxlogdet
