function id = eidors_var_id(varargin)
% EIDORS keeps what it has computed under a hash of what it was computed from. It has a compiled
% function for that; where that is not built, this one of the same name does it in Octave alone.
  id = ['id_' upper(hash('sha1', parts_of(varargin)))];
end

function text = parts_of(value)
  if isstruct(value)
    names = sort(fieldnames(value));
    values = cell(1, numel(names) * numel(value));
    at = 0;
    for i = 1:numel(value)
      for k = 1:numel(names)
        at = at + 1;
        values{at} = [names{k} '=' parts_of(value(i).(names{k})) ';'];
      end
    end
    text = ['s' sprintf('%d,', size(value)) values{:}];
  elseif iscell(value)
    values = cellfun(@parts_of, value(:)', 'UniformOutput', false);
    text = ['c' sprintf('%d,', size(value)) values{:}];
  elseif isa(value, 'function_handle')
    text = ['f' func2str(value)];
  elseif issparse(value)
    [i, j, v] = find(value);
    text = ['m' sprintf('%d,', size(value)) bytes_of([i(:); j(:); v(:)])];
  else
    text = [class(value)(1) sprintf('%d,', size(value)) bytes_of(value(:))];
  end
end

function text = bytes_of(values)
  if ischar(values)
    text = values(:)';
  elseif isempty(values)
    text = '';
  elseif islogical(values)
    text = char(uint8(values(:)'));
  else
    values = full(values(:)');
    if iscomplex(values)
      values = [real(values) imag(values)];
    end
    text = char(typecast(values, 'uint8'));
  end
end
