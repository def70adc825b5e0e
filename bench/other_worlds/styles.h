// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "world.h"

namespace other_worlds {

// Places outdoors: a loop through a hilly forest, the lanes of an old town, a straight motorway, a
// village on a slope, and a car park.
World forest(Random& random);
World oldTown(Random& random);
World motorway(Random& random);
World village(Random& random);
World carPark(Random& random);

// Places indoors: a warehouse with rows of racks, and a home of six rooms along a corridor.
World warehouse(Random& random);
World home(Random& random);

}  // namespace other_worlds
