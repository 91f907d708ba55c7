// Where images come and go by the dozen for each pair.
#pragma once

namespace periplus::vision {

// For this process from now on: freed memory of images is kept for the next ones, up to some 128 MB, instead of being given back to the system, which
// hands out and clears every page of it anew. Does nothing where the C library has no such settings.
void keep_image_memory();

}  // namespace periplus::vision
