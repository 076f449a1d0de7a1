/* Sine and cosine of angles of at most @limit@ rad, within 1 ulp. */
static inline ROBOVEC_PRECISE void robovec_circular_@suffix@(const @vector@ *angle, @vector@ *sine, @vector@ *cosine,
    @bits@ *far)
{
    ROBOVEC_AS_WRITTEN
    const @vector@ x = *angle;
    *far |= @most@ - ((@bits@)x & @mask@);
    /* The nearest number of quarter turns: as an integer in the last bits. */
    @vector@ counted = x * @turns@ + @rounder@;
    const @bits@ count = (@bits@)counted;
    const @vector@ turns = counted - @rounder@;
    /* r + low = x - turns * pi/2; the first products are exact. */
    @vector@ near = x - turns * @first@;
@reduction@    const @vector@ z = r * r;
    const @vector@ zz = z * z;
    const @vector@ half = z * @half@;
    const @vector@ head = @one@ - half;
    const @vector@ s = r + (r * z * (@sine_polynomial@) + low * head);
    const @vector@ c = head + ((@one@ - head - half) + (zz * (@cosine_polynomial@) - r * low));
    /* Odd counts exchange the two, and every second pair changes signs. */
    const @bits@ odd = -(count & 1@ones@);
    const @bits@ a = ((@bits@)c & odd) | ((@bits@)s & ~odd);
    const @bits@ b = ((@bits@)s & odd) | ((@bits@)c & ~odd);
    const @bits@ signs = @signs@ + (@bits@){0};
    *sine = (@vector@)(a ^ ((count << @shift@) & signs));
    *cosine = (@vector@)(b ^ (((count + 1@ones@) << @shift@) & signs));
}
