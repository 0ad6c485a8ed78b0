% Fills a worksheet of `check::constraint(...).phi_q(...)`, in Matlab or Octave: worksheet("sheet.json", "filled.json").
function worksheet(given, filled)
    sheet = jsondecode(fileread(given));
    for k = 1:numel(sheet.blocks(1).points)
        at = sheet.blocks(1).points(k).at;
        sheet.blocks(1).points(k).value = phi_q(at.q, at.b);
    end
    file = fopen(filled, "w");
    fprintf(file, "%s", jsonencode(sheet));
    fclose(file);
end
