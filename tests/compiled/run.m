% Calls functions of equations at states that depend on names alone, and prints
% every element that a call changed; what Octave refuses is named. Lines behind
% `> ` are ours, since a statement without a semicolon prints as well.
1;
function x = times(a, b)
  % The product of two 64-bit numbers, without the bits above.
  mask = uint64(4294967295);
  low = bitand(a, mask); high = bitshift(a, -32);
  l = bitand(b, mask); h = bitshift(b, -32);
  cross = plus_(wide(high, l), wide(low, h));
  x = plus_(wide(low, l), bitshift(bitand(cross, mask), 32));
end
function x = wide(a, b)
  % The product of two 32-bit numbers, by halves that stay exact.
  x = uint64(0);
  for shift = [0 16]
    part = bitand(bitshift(b, -shift), uint64(65535));
    x = plus_(x, bitshift(a * part, shift));
  end
end
function x = plus_(a, b)
  % The sum of two 64-bit numbers, without the carry.
  half = uint64(9223372036854775807);
  x = bitand(a, half) + bitand(b, half);
  x = bitxor(x, bitand(bitxor(a, b), bitcmp(half)));
end
function y = number(state, name, i, j)
  x = plus_(uint64(1469598103934665603), uint64(state));
  for byte = uint64(name)
    x = times(bitxor(x, byte), uint64(1099511628211));
  end
  x = plus_(x, times(uint64(i), hex('9e3779b97f4a7c15')));
  x = plus_(x, times(uint64(j), hex('c2b2ae3d27d4eb4f')));
  x = times(bitxor(x, bitshift(x, -30)), hex('bf58476d1ce4e5b9'));
  x = times(bitxor(x, bitshift(x, -27)), hex('94d049bb133111eb'));
  x = bitxor(x, bitshift(x, -31));
  y = (double(bitshift(x, -11)) + 0.5) / 2^52 - 1.0;
end
function x = hex(text)
  x = bitor(bitshift(uint64(hex2dec(text(1:8))), 32), uint64(hex2dec(text(9:16))));
end
function array = given(state, name, rows, columns)
  for i = 1:rows
    for j = 1:columns
      array(i, j) = number(state, name, i, j * (columns > 1));
    end
  end
end
for state = 1:STATES
  for name = {'q', 'qd', 'qdd', 'm', 'g', 'lrod'}
    s.(name{1}) = given(state, name{1}, EXTENT, 1);
  end
  for name = {'dpt', 'l', 'In', 'frc', 'trq'}
    s.(name{1}) = given(state, name{1}, EXTENT, EXTENT);
  end
  s.tsim = number(state, 'tsim', 0, 0);
  for call = 1:numel(NAMES)
    printf('\n> call %d %d\n', state, call - 1);
    try
      source(NAMES{call});
      results = invdyna(s, s.tsim, []);
      for i = 1:numel(results)
        printf('\n> Qq %d 0 %s\n', i, num2hex(results(i)));
      end
    catch
      printf('\n> refused\n');
    end
  end
end
