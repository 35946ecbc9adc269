"""L1 + D-SSIM (Wang et al. 2004) and its gradient in four passes over planes [3, H, W].

    pictures and their products, blurred along the row
    the same blurred along the column -> SSIM and its partial derivatives by what was blurred
    the derivatives, blurred along the row
    the same blurred along the column -> the gradient, and L1

Outside the picture everything is zero, as in a convolution with zero padding.
"""

import math

import triton
import triton.language as tl

__all__ = ["blur_derivatives", "blur_pictures", "differentiate_ssim", "write_gradient"]

C1, C2 = tl.constexpr(0.01**2), tl.constexpr(0.03**2)
_GAUSSIAN = [math.exp(-(d**2) / (2 * 1.5**2)) for d in range(-5, 6)]  # sigma 1.5 pixels; all taps add up to 1
TAP_0, TAP_1, TAP_2, TAP_3, TAP_4, TAP_5 = (tl.constexpr(tap / sum(_GAUSSIAN)) for tap in _GAUSSIAN[5:])


@triton.jit
def pixel(width, height, BLOCK: tl.constexpr):
    """This program's pixels: place in the three planes, column, row of its plane, and whether there is such a pixel."""
    i = tl.program_id(0) * BLOCK + tl.arange(0, BLOCK)
    return i, i % width, i // width % height, i < 3 * width * height


@triton.jit
def both_sides(array, i, place, size, stride, mask, d):
    """The sum of an array's values `d` places before and after."""
    before = tl.load(array + i - d * stride, mask=mask & (place >= d), other=0.0)
    return before + tl.load(array + i + d * stride, mask=mask & (place + d < size), other=0.0)


@triton.jit
def blurred(array, i, place, size, stride, mask):
    """An array blurred along the axis of which `place` is the coordinate."""
    total = tl.load(array + i, mask=mask, other=0.0) * TAP_0
    total += both_sides(array, i, place, size, stride, mask, 1) * TAP_1
    total += both_sides(array, i, place, size, stride, mask, 2) * TAP_2
    total += both_sides(array, i, place, size, stride, mask, 3) * TAP_3
    total += both_sides(array, i, place, size, stride, mask, 4) * TAP_4
    return total + both_sides(array, i, place, size, stride, mask, 5) * TAP_5


@triton.jit
def add_pair(image, target, i, column, width, mask, d, weight: tl.constexpr, sums):
    """The sums of both pictures, their squares and their product, with the pixels `d` places before and after."""
    near, far = mask & (column >= d), mask & (column + d < width)
    a0, a1 = tl.load(image + i - d, mask=near, other=0.0), tl.load(image + i + d, mask=far, other=0.0)
    b0, b1 = tl.load(target + i - d, mask=near, other=0.0), tl.load(target + i + d, mask=far, other=0.0)
    squares = (a0 * a0 + b0 * b0) + (a1 * a1 + b1 * b1)
    return (
        sums[0] + (a0 + a1) * weight,
        sums[1] + (b0 + b1) * weight,
        sums[2] + squares * weight,
        sums[3] + (a0 * b0 + a1 * b1) * weight,
    )


@triton.jit
def blur_pictures(image, target, blurs, width, height, BLOCK: tl.constexpr):
    """Blurs [4, 3, H, W] along the row: of image, target, the sum of their squares, and their product."""
    i, column, _, mask = pixel(width, height, BLOCK)
    a = tl.load(image + i, mask=mask, other=0.0)
    b = tl.load(target + i, mask=mask, other=0.0)
    sums = a * TAP_0, b * TAP_0, (a * a + b * b) * TAP_0, a * b * TAP_0
    sums = add_pair(image, target, i, column, width, mask, 1, TAP_1, sums)
    sums = add_pair(image, target, i, column, width, mask, 2, TAP_2, sums)
    sums = add_pair(image, target, i, column, width, mask, 3, TAP_3, sums)
    sums = add_pair(image, target, i, column, width, mask, 4, TAP_4, sums)
    mean_1, mean_2, squares, product = add_pair(image, target, i, column, width, mask, 5, TAP_5, sums)
    count = 3 * width * height
    tl.store(blurs + i, mean_1, mask=mask)
    tl.store(blurs + count + i, mean_2, mask=mask)
    tl.store(blurs + 2 * count + i, squares, mask=mask)
    tl.store(blurs + 3 * count + i, product, mask=mask)


@triton.jit
def differentiate_ssim(blurs, derivatives, sums, width, height, scale, BLOCK: tl.constexpr):
    """SSIM, summed per program, and `scale` times its derivatives [3, 3, H, W].

    The derivatives are those by the blurred image, squares (twice that) and product. Windows around pixels of odd
    column, or of a row that is no multiple of three, do not count: theirs are zero.
    """
    i, column, row, mask = pixel(width, height, BLOCK)
    counts = mask & (column % 2 == 0) & (row % 3 == 0)
    count = 3 * width * height
    mean_1 = blurred(blurs, i, row, height, width, counts)
    mean_2 = blurred(blurs + count, i, row, height, width, counts)
    squares = blurred(blurs + 2 * count, i, row, height, width, counts)
    product = blurred(blurs + 3 * count, i, row, height, width, counts)
    both, means = mean_1 * mean_2, mean_1 * mean_1 + mean_2 * mean_2
    a1, a2 = 2.0 * both + C1, 2.0 * (product - both) + C2
    b1, b2 = means + C1, (squares - means) + C2
    inverse = 1.0 / (b1 * b2)
    ssim = tl.where(counts, a1 * a2 * inverse, 0.0)
    scaled = tl.where(counts, inverse * (2.0 * scale), 0.0)
    tl.store(derivatives + i, scaled * (mean_2 * (a2 - a1) + mean_1 * (ssim * (b1 - b2))), mask=mask)
    tl.store(derivatives + count + i, -scaled * (ssim * b1), mask=mask)
    tl.store(derivatives + 2 * count + i, scaled * a1, mask=mask)
    tl.store(sums + tl.program_id(0), tl.sum(ssim, axis=0))


@triton.jit
def blur_derivatives(derivatives, blurs, width, height, BLOCK: tl.constexpr):
    """The derivatives blurred along the row."""
    i, column, _, mask = pixel(width, height, BLOCK)
    count = 3 * width * height
    tl.store(blurs + i, blurred(derivatives, i, column, width, 1, mask), mask=mask)
    tl.store(blurs + count + i, blurred(derivatives + count, i, column, width, 1, mask), mask=mask)
    tl.store(blurs + 2 * count + i, blurred(derivatives + 2 * count, i, column, width, 1, mask), mask=mask)


@triton.jit
def write_gradient(image, target, blurs, gradient, sums, width, height, scale, BLOCK: tl.constexpr):
    """The gradient, with `scale` times the sign of the difference; magnitudes are summed by each program."""
    i, _, row, mask = pixel(width, height, BLOCK)
    count = 3 * width * height
    a = tl.load(image + i, mask=mask, other=0.0)
    b = tl.load(target + i, mask=mask, other=0.0)
    by_mean = blurred(blurs, i, row, height, width, mask)
    by_squares = blurred(blurs + count, i, row, height, width, mask)
    by_product = blurred(blurs + 2 * count, i, row, height, width, mask)
    sign = tl.where(a > b, 1.0, tl.where(a < b, -1.0, 0.0)) * scale
    tl.store(gradient + i, by_mean + sign + (a * by_squares + b * by_product), mask=mask)
    tl.store(sums + tl.program_id(0), tl.sum(tl.abs(a - b), axis=0))
