// SPDX-License-Identifier: MIT
#include "tests/support/stores.hpp"

#include <cmath>
#include <iterator>

namespace maxlogdet::test {

BlockStore random_store(Random& random, std::size_t n, double scale, int rows) {
  return store_of(n, [&](std::size_t) { return random_block(random, rows > 0 ? rows : random.integer(1, 3), scale); });
}

BlockStore ill_conditioned_blocks(Random& random, std::size_t n) {
  const double scale = std::pow(10.0, random.uniform(-3, 7));
  const double spread = random.chance(0.3) ? 0 : std::pow(10.0, random.uniform(-12, 0));
  const Block basis = random_block(random, random.integer(1, 5));
  return store_of(n, [&](std::size_t) {
    const int rows = random.integer(1, 3);
    const Block mixture = random_block(random, rows, scale).leftCols(basis.rows()) * basis;
    return Block(mixture + random_block(random, rows, scale * spread));
  });
}

BlockStore scaled(Random& random, const BlockStore& blocks, double scale, double invalid_share) {
  BlockStore made;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!blocks.is_valid(i) || random.chance(invalid_share)) {
      made.push_back_invalid();
    } else {
      push_back(made, Block(stored_block(blocks, i) * scale));
    }
  }
  return made;
}

BlockStore pushed(const BlockStore& blocks) {
  Random none;
  return scaled(none, blocks, 1);
}

BlockStore any_blocks(Random& random, std::size_t n) {
  const int sort = random.integer(0, 5);
  if (sort == 0) return awkward_blocks(random, n);
  if (sort == 1) {  // each several times, in any order
    const BlockStore different = awkward_blocks(random, 1 + n / 4);
    return store_of(n, [&](std::size_t) { return stored_block(different, random.index(different.size())); });
  }
  const sim::Scene scene = sim::scenes[random.index(std::size(sim::scenes))];
  const BlockKind& kind = block_kinds[random.index(std::size(block_kinds))];
  const BlockStore blocks = blocks_of(make_scene(scene, n, random.seed()), kind);
  return sort == 2 ? pushed(blocks) : blocks;
}

}  // namespace maxlogdet::test
